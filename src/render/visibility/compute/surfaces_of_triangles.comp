#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// The surfaces of multisampled pixels, from their visible triangles. Samples of one triangle show one surface; two
// triangles show one surface if their G-buffer values are similar (same_surface.glsl). A triangle joins the first
// surface whose first triangle it matches.
#define MULTISAMPLED
#define SAMPLE_LAYERS
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#define GBUFFER_NO_SURFACES
#include "render/glsl/gbuffer_read.glsl"
#include "render/visibility/same_surface.glsl"
#define SURFACES_BINDING GBUFFER_BINDINGS
#include "render/visibility/compute/pixel_surfaces.glsl"

Sample readTriangle(View view, ivec3 pixel, uint first, uint samples) {
  int index = findLSB(samples);
  Sample r;
  r.depth = meanDepth(first, samples);
  r.light = fetchSample(lightOfSamples, pixel, index);
  vec2 place = vec2(pixel.xy) + sampleCentroid(samples);
  r.s = unpackSurface(view, place, readTexel(pixel, index), r.depth, r.light.a);
  return r;
}

// Returns the samples of the first remaining triangle and of all triangles that match it.
uint nextSurface(View view, ivec3 pixel, uint first, inout uint left) {
  VisibleRef visible = VisibleRef(push.visible);
  uint surface = nextTriangle(visible, first, left), others = left;
  if (others == 0u || kEverySample != 0u) return surface;
  Sample one = readTriangle(view, pixel, first, surface);
  while (others != 0u) {
    uint samples = nextTriangle(visible, first, others);
    Sample other = readTriangle(view, pixel, first, samples);
    if (sameSurface(one, other, pixelSize(view, max(one.depth, other.depth)))) surface |= samples;
  }
  left &= ~surface;
  return surface;
}
