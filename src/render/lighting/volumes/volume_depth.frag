#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled
// Light volumes: copies depth to a depth-stencil target. With several samples per pixel, each sample gets the depth of
// its surface, because a surface is lit at one position. (In a pixel that spans meters, a light may reach that position
// but not all of the samples.)
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/lighting/volumes/volume_push.h"
layout(set = 0, binding = 0) uniform TARGET_SAMPLER depthSource;
#ifdef MULTISAMPLED
layout(set = 0, binding = 1) uniform usampler2DArray pixelSurfaces;
#endif
layout(push_constant, scalar) uniform Push { VolumePush push; };

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
#ifdef MULTISAMPLED
  uint surface = surfaceWithSample(pixelSurfaces, pixel, uint(gl_SampleID));
  gl_FragDepth = depthOfSamples(depthSource, pixel, surface);
#else
  gl_FragDepth = texelFetch(depthSource, pixel, 0).r;
#endif
}
