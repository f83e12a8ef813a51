#version 460
#extension GL_GOOGLE_include_directive : require
// Copies depth to where there is stencil beside it: with several samples a pixel, each one's.
#include "render/glsl/multisample.glsl"
layout(set = 0, binding = 0) uniform TARGET_SAMPLER depthSource;
layout(push_constant) uniform Push { layout(offset = 16) uint view; };  // as volume_push.glsl has it

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(view));
#ifdef MULTISAMPLED
  gl_FragDepth = texelFetch(depthSource, pixel, gl_SampleID).r;
#else
  gl_FragDepth = texelFetch(depthSource, pixel, 0).r;
#endif
}
