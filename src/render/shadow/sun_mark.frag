#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// Sun occlusion, first step: marks the pixels that face the sun in stencil. The others are discarded.
#include "render/glsl/common.glsl"
#define ONE_SAMPLE
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/shadow/sun_push.h"

layout(push_constant, scalar) uniform Push { SunPush push; };

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  Surface s = readSurface(frameView(FrameRef(push.frame).v, push.view), pixel, depth, 1.0);
  if (depth == 0.0 || dot(s.normal, push.sun.direction) >= 0.0) discard;
}
