#version 460
#extension GL_GOOGLE_include_directive : require
// One iteration of an edge-avoiding wavelet transform (Dammertz, Sewtz, Hanika and Lensch 2010, Edge-Avoiding A-Trous
// Wavelet Transform for Fast Global Illumination Filtering), whose tolerance for differences of luminance follows the
// pixel's variance (Schied et al. 2017, Spatiotemporal Variance-Guided Filtering). Inputs and outputs:
// indirect_filter.glsl.
#include "render/lighting/reference/indirect_filter.glsl"

const float kTolerance = 4.0;  // standard deviations

struct FilteredSignal {
  vec4 sum;  // w: of variances
  float weight;
};

// Standard deviation, from a mean of the variance over 3 x 3 pixels.
float deviation(sampler2DArray light, ivec3 place) {
  float sum = 0.0, weights = 0.0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      ivec3 at = place + ivec3(x, y, 0);
      if (!inFrame(at.xy)) continue;
      float weight = float((2 - abs(x)) * (2 - abs(y)));
      sum += weight * texelFetch(light, at, 0).a;
      weights += weight;
    }
  return sqrt(sum / weights);
}

void add(inout FilteredSignal f, vec4 own, vec4 other, float deviation, float weight) {
  float difference = abs(luminance(own.rgb) - luminance(other.rgb));
  weight *= exp(-difference / (kTolerance * deviation + 1e-6));
  f.sum += other * vec4(vec3(weight), weight * weight);
  f.weight += weight;
}
vec4 resultOf(FilteredSignal f) { return f.sum / vec4(vec3(f.weight), f.weight * f.weight); }

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (!inFrame(place.xy)) return;
  FilterSurface own = filterSurface(place);
  vec4 scattered = texelFetch(scatteredLight, place, 0), mirrored = texelFetch(mirroredLight, place, 0);
  float ofScattered = deviation(scatteredLight, place), ofMirrored = deviation(mirroredLight, place);
  float roughness = texelFetch(scatteredAlbedo, place, 0).a;
  float sharpness = lobeSharpness(roughness);
  // Smooth lobes mirror other surfaces, whose edges the guide does not contain.
  float mirrorReach = min(1.0, 24.0 * roughness / float(push.step));
  const float kWeights[3] = {0.375, 0.25, 0.0625};  // B3 spline
  FilteredSignal a = FilteredSignal(scattered * vec4(vec3(0.140625), 0.019775390625), 0.140625);
  FilteredSignal b = FilteredSignal(mirrored * vec4(vec3(0.140625), 0.019775390625), 0.140625);
  for (int y = -2; own.some && y <= 2; ++y)
    for (int x = -2; x <= 2; ++x) {
      ivec3 at = place + ivec3(x, y, 0) * ivec3(push.step, push.step, 1);
      if (!inFrame(at.xy) || (x == 0 && y == 0)) continue;
      FilterSurface other = filterSurface(at);
      float weight = kWeights[abs(x)] * kWeights[abs(y)];
      add(a, scattered, texelFetch(scatteredLight, at, 0), ofScattered,
          weight * surfaceWeight(own, other, kScatteredSharpness));
      add(b, mirrored, texelFetch(mirroredLight, at, 0), ofMirrored,
          weight * mirrorReach * surfaceWeight(own, other, sharpness));
    }
  imageStore(filteredScattered, place, resultOf(a));
  imageStore(filteredMirrored, place, resultOf(b));
}
