#version 460
#extension GL_GOOGLE_include_directive : require
// Motion vectors of the background.
#include "render/glsl/common.glsl"
#include "render/visibility/draw_push.h"
#include "render/visibility/background_motion.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };

layout(constant_id = kDrawnMotionOfSurfacesConstant) const uint kMotionOfSurfaces = 0;

layout(location = 0) out vec4 motion;

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  motion = backgroundMotion(frame, frameView(frame, push.view), push.view, gl_FragCoord.xy);
  if (kMotionOfSurfaces != 0u) motion.zw = vec2(1.0, 0.0);
}
