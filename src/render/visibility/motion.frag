#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// Motion vectors of the visible surfaces, to the previous and to the next frame.
#include "render/glsl/common.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/fragment_point.glsl"
#include "render/visibility/motion_varyings.glsl"

layout(constant_id = kAlphaMaskedConstant) const uint kAlphaMasked = 0;

layout(constant_id = kDrawnMotionOfSurfacesConstant) const uint kMotionOfSurfaces = 0;

layout(location = 0) out vec4 motion;

void main() {
  View view = frameView(FrameRef(push.frame).v, push.view);
  motion = surfaceMotion(view.size);
  if (kMotionOfSurfaces != 0u)
    motion.zw = vec2(length(varyingSeenBefore) / max(distance(varyingPosition.xyz, view.eye), 1e-20),
                     float(varyingInstance + 1u));
  // Last, as in geometry.frag, because textures need the whole quad.
  if (kAlphaMasked != 0u && masked(drawMaterial(), fragmentPoint())) discard;
}
