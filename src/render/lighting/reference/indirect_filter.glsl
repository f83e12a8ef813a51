// The common part of the filter's passes: the inputs, and the weight of a neighbor by its surface.
#include "render/glsl/common.glsl"
#include "render/glsl/halves.glsl"
#include "render/lighting/reference/indirect_filter_push.h"
#include "shared/color.h"
#include "shared/normal/octahedral.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray scatteredLight;
layout(set = 0, binding = 1) uniform sampler2DArray mirroredLight;
layout(set = 0, binding = 2) uniform usampler2DArray filterGuide;
layout(set = 0, binding = 3) uniform sampler2DArray scatteredAlbedo;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2DArray filteredScattered;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2DArray filteredMirrored;

layout(push_constant, scalar) uniform Push { IndirectFilterPush push; };

struct FilterSurface {
  vec3 position;
  vec3 normal;
  bool some;  // there is a surface
};

FilterSurface filterSurface(ivec3 place) {
  uvec4 guide = texelFetch(filterGuide, place, 0);
  FilterSurface s;
  s.some = any(notEqual(guide, uvec4(0u)));
  s.position = uintBitsToFloat(guide.xyz);
  s.normal = directionFromOctahedral(unpackSnorm2x16(guide.w));
  return s;
}

// The weight of a neighbor: 1 in the surface's plane, and 0 behind an edge of depth or of normals. Deviations from the
// plane are relative to the distance, so that the weight depends neither on the resolution nor on the scene's size.
float surfaceWeight(FilterSurface own, FilterSurface other, float sharpness) {
  if (!other.some) return 0.0;
  vec3 offset = other.position - own.position;
  float away = max(abs(dot(offset, own.normal)), abs(dot(offset, other.normal)));
  float bend = max(dot(own.normal, other.normal), 0.0);
  return pow(bend, sharpness) * exp(-8.0 * away / max(length(offset), 1e-20));
}

// Rougher lobes see the same light over larger differences of normals.
float lobeSharpness(float roughness) { return 32.0 + 8.0 / max(roughness * roughness, 0.01); }
const float kScatteredSharpness = 48.0;

bool inFrame(ivec2 place) {
  return all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, textureSize(scatteredLight, 0).xy));
}
