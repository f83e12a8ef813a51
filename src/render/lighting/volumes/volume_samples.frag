#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// Light volumes: as volume.frag, with one fragment per sample, for pixels whose samples show different surfaces.
#define MULTISAMPLED
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/lighting/volumes/volume_light.glsl"

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
  lightSurface(pixel, surfaceWithSample(pixelSurfaces, pixel, uint(gl_SampleID)));
}
