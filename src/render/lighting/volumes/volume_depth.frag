#version 460
#extension GL_GOOGLE_include_directive : require
// Copies depth to where there is stencil beside it: with several samples a pixel, for each sample that of its surface,
// which is lit in one place. (Where a pixel spans metres a light may reach that place and not all of the samples.)
#include "render/glsl/multisample.glsl"
layout(set = 0, binding = 0) uniform TARGET_SAMPLER depthSource;
#ifdef MULTISAMPLED
layout(set = 0, binding = 1) uniform usampler2DArray pixelSurfaces;
#endif
layout(push_constant) uniform Push { layout(offset = 16) uint view; };  // as volume_push.glsl has it

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(view));
#ifdef MULTISAMPLED
  uint surface = surfaceWithSample(texelFetch(pixelSurfaces, pixel, 0).r, uint(gl_SampleID));
  gl_FragDepth = depthOfSamples(depthSource, pixel, surface);
#else
  gl_FragDepth = texelFetch(depthSource, pixel, 0).r;
#endif
}
