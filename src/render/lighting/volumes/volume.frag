#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, multisampled
// Light volumes: shades the pixels that a light's volume covers with that light, for additive blending, with one
// fragment per pixel. In pixels with several surfaces, volume_samples.frag lights each sample instead.
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/lighting/volumes/volume_light.glsl"

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
#ifdef MULTISAMPLED
  lightSurface(pixel, texelFetch(pixelSurfaces, pixel, 0).r);
#else
  lightSurface(pixel, 1u);
#endif
}
