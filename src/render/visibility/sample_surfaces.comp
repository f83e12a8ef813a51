#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout
// Per-sample classification: groups each pixel's samples by the surface they show, so that a pixel is lit once for each
// surface. Pixels with several surfaces are those shaded per sample.
//
// A fragment that covers a whole pixel writes one value to all its samples, so bit-identical samples need no further
// comparison. This detects what SV_Coverage detects (Thibieroz 2009), and also works where surfaces intersect. Most
// pixels with differing samples still show one surface (same_surface.glsl).
#define MULTISAMPLED
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#define GBUFFER_NO_SURFACES
#include "render/glsl/gbuffer_read.glsl"
#include "render/visibility/same_surface.glsl"
#include "render/lighting/lighting_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = GBUFFER_BINDINGS, r32ui) uniform writeonly uimage2DArray surfacesTarget;

layout(push_constant, scalar) uniform Push { LightingPush push; };

// Returns true if all samples equal the first.
bool surfacesAreEqual(ivec3 pixel) {
  GbufferTexel first = readTexel(pixel, 0);
  vec4 light = texelFetch(lightOfSamples, pixel, 0);
  bool alike = true;
  for (int i = 1; i < 4; ++i) {
    GbufferTexel other = readTexel(pixel, i);
#define SAME_TARGET(index, name, format, type, channels) alike = alike && first.name == other.name;
    GBUFFER_TARGETS(SAME_TARGET)
    alike = alike && light == texelFetch(lightOfSamples, pixel, i);
  }
  return alike;
}

Sample readSample(View view, ivec3 pixel, int index, float depth) {
  Sample r;
  r.depth = depth;
  r.light = texelFetch(lightOfSamples, pixel, index);
  r.s = unpackSurface(view, vec2(pixel.xy) + samplePlace(kSamples, uint(index)), readTexel(pixel, index), depth,
                      r.light.a);
  return r;
}

// Each sample joins the first surface whose first sample it matches.
uint partSamples(View view, ivec3 pixel, vec4 depths) {
  Sample samples[4];
  for (int i = 0; i < 4; ++i) samples[i] = readSample(view, pixel, i, depths[i]);
  float size = pixelSize(view, max(max(depths.x, depths.y), max(depths.z, depths.w)));
  uint surfaces = 0u, joined = 0u, count = 0u;
  for (int i = 0; i < 4; ++i) {
    uint members = 0u;
    for (int j = i; j < 4; ++j) {
      bool waits = depths[j] != 0.0 && depths[i] != 0.0 && ((joined >> i | joined >> j) & 1u) == 0u;
      bool same = j == i || (kEverySample == 0u && sameSurface(samples[i], samples[j], size));
      if (waits && same) members |= 1u << j;
    }
    joined |= members;
    surfaces |= members << (4u * count);
    if (members != 0u) ++count;
  }
  return surfaces;
}

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(FrameRef(push.frame).v, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  vec4 depths;
  uint covered = 0u;
  for (int i = 0; i < 4; ++i) {
    depths[i] = texelFetch(gbufferDepth, pixel, i).r;
    if (depths[i] != 0.0) covered |= 1u << i;
  }
  bool part = bitCount(covered) > 1 && (kEverySample != 0u || covered != 15u || !surfacesAreEqual(pixel));
  uint surfaces = covered;
  if (part) surfaces = partSamples(view, pixel, depths);
  imageStore(surfacesTarget, pixel, uvec4(surfaces));
}
