#version 460
#extension GL_GOOGLE_include_directive : require
// Prepares the filter of indirect light: replaces the variance that a pixel's few samples suggest by one to which its
// neighbors on the same surface contribute, and limits values far above those of all neighbors (fireflies). Inputs and
// outputs: indirect_filter.glsl. With kHistory, the more frames a signal has, the less the spread of its neighbors
// counts, because it then is that of the light itself.
#include "render/lighting/reference/indirect_filter.glsl"

layout(constant_id = kHistoryConstant) const uint kHistory = 0;
layout(set = 0, binding = 6) uniform usampler2DArray historySurface;  // nextSurface of indirect_temporal.comp

const int kReach = 3;

// The mean and the spread of a signal over neighbors.
struct Neighborhood {
  float weight;
  float mean, square;  // of luminance
  float variance;      // mean of the pixels' own
  float highest;       // luminance of all others
};

void add(inout Neighborhood n, vec4 signal, float weight, bool own) {
  float light = luminance(signal.rgb);
  n.weight += weight;
  n.mean += weight * light;
  n.square += weight * light * light;
  n.variance += weight * signal.a;
  if (!own && weight > 0.05) n.highest = max(n.highest, light);
}

// Returns the signal of so many frames with its estimated variance.
vec4 estimated(Neighborhood n, vec4 signal, float frames) {
  float mean = n.mean / n.weight;
  float spread = max(n.square / n.weight - mean * mean, 0.0);
  float light = luminance(signal.rgb);
  float limit = n.highest > 0.0 && light > n.highest ? n.highest / light : 1.0;
  float variance = max(n.variance / n.weight, 0.25 * spread / frames);
  return vec4(signal.rgb * limit, variance);
}

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (!inFrame(place.xy)) return;
  FilterSurface own = filterSurface(place);
  Neighborhood scattered = Neighborhood(1e-6, 0.0, 0.0, 0.0, 0.0), mirrored = scattered;
  vec4 signal = texelFetch(scatteredLight, place, 0), mirror = texelFetch(mirroredLight, place, 0);
  float sharpness = lobeSharpness(texelFetch(scatteredAlbedo, place, 0).a);
  for (int y = -kReach; own.some && y <= kReach; ++y)
    for (int x = -kReach; x <= kReach; ++x) {
      ivec3 at = place + ivec3(x, y, 0) * ivec3(push.step, push.step, 1);
      if (!inFrame(at.xy)) continue;
      FilterSurface other = filterSurface(at);
      add(scattered, texelFetch(scatteredLight, at, 0), surfaceWeight(own, other, kScatteredSharpness), at == place);
      add(mirrored, texelFetch(mirroredLight, at, 0), surfaceWeight(own, other, sharpness), at == place);
    }
  vec2 frames = kHistory != 0u ? floatsFromHalves(texelFetch(historySurface, place, 0).w) : vec2(1.0);
  imageStore(filteredScattered, place, own.some ? estimated(scattered, signal, frames.x) : vec4(0.0));
  imageStore(filteredMirrored, place, own.some ? estimated(mirrored, mirror, frames.y) : vec4(0.0));
}
