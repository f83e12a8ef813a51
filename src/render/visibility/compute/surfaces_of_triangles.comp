#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// The surfaces of pixels of several samples, from the triangles that they show: samples of one triangle show one surface,
// those of two do if what the G-buffer has of both is alike. A triangle joins the first surface whose first triangle it
// matches. Also the depth in the middle of each surface, where it is lit.
#define MULTISAMPLED
#define SAMPLE_LAYERS
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#define GBUFFER_NO_SURFACES
#include "render/glsl/gbuffer_read.glsl"
#include "render/gbuffer/same_surface.glsl"
#include "render/visibility/compute/raster_push.h"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/compute/pixel_triangles.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = GBUFFER_BINDINGS, r32f) uniform writeonly image2DArray depthTarget;
layout(set = 0, binding = 1 + GBUFFER_BINDINGS, r32ui) uniform writeonly uimage2DArray surfacesTarget;

layout(push_constant, scalar) uniform Push { ResolvePush push; };

float meanDepth(uint first, uint samples) {
  VisibleRef visible = VisibleRef(push.visible);
  precise float sum = 0.0;
  for (uint i = 0u; i < kSamples; ++i)
    sum += hasSample(samples, i) ? visibleDepth(visible.v[first + i]) : 0.0;
  precise float mean = sum / float(bitCount(samples));
  return mean;
}

Sample readTriangle(View view, ivec3 pixel, uint first, uint samples) {
  int index = findLSB(samples);
  Sample r;
  r.depth = meanDepth(first, samples);
  r.light = fetchSample(lightOfSamples, pixel, index);
  vec2 place = vec2(pixel.xy) + middleOfSamples(samples);
  r.s = unpackSurface(view, place, readTexel(pixel, index), r.depth, r.light.a);
  return r;
}

// The samples of the first triangle that is left, and of those that match it; takes them out of `left`.
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

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(FrameRef(push.frame).v, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  uint first = visibleIndex(uvec3(pixel), uvec2(view.size)), count = 0u;
  uint left = coveredSamples(VisibleRef(push.visible), first);
  for (uint layer = 0u; layer < surfaceLayers(kSamples); ++layer) {
    uint some = 0u;
    for (uint i = 0u; i < surfacesALayer(kSamples) && left != 0u; ++i) {
      uint surface = nextSurface(view, pixel, first, left);
      imageStore(depthTarget, sampleLayer(pixel, uint(findLSB(surface))), vec4(meanDepth(first, surface)));
      some |= surface << (kSamples * i);
    }
    imageStore(surfacesTarget, ivec3(pixel.xy, pixel.z * int(surfaceLayers(kSamples)) + int(layer)), uvec4(some));
  }
}
