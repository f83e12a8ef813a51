#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// Sun occlusion, second step: at the pixels that sun_mark.frag marked, looks up the shadow maps of the sun and writes
// the result to the alpha channel of a G-buffer target.
#include "render/glsl/common.glsl"
#define ONE_SAMPLE
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/shadow.glsl"
#include "render/shadow/sun_push.h"

layout(push_constant, scalar) uniform Push { SunPush push; };

layout(location = 0) out vec4 occlusion;

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  Surface s = readSurface(frameView(FrameRef(push.frame).v, push.view), pixel, depth, 1.0);
  FrameConstants frame = FrameRef(push.frame).v;
  occlusion = vec4(shadowByMaps(frame, push.sun, push.shadow, s, -push.sun.direction));
}
