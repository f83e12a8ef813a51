// Directions of the environment in proportion to their brightness, for rays: by the inverse of the cumulative
// distributions that the scene's BVHs refer to (RayScene::environment). Define SKY_PICTURE, the environment's
// equirectangular image, before the include.
#ifndef LATELIGHT_SKY_SAMPLES_GLSL
#define LATELIGHT_SKY_SAMPLES_GLSL
#include "render/glsl/rays.glsl"
#include "render/glsl/setup.glsl"
#include "shared/environment.h"

// Returns true if the view has the environment of this index. Images of environments differ in size, so a pass samples
// one of them.
bool isOwnSky(FrameConstants frame, uint environment) {
  return kWorlds == 0u || (frame.environmentMap & kEnvironmentLayerMask) == environment;
}

// Returns the address of an environment's table. Those of the environments of worlds follow each other.
uint64_t skyTable(FrameConstants frame, RayScene scene) {
  uint64_t table = scene.environment;
  if (kWorlds != 0u) table += uint64_t(frame.environmentMap & kEnvironmentLayerMask) * kEnvironmentTableBytes;
  return table;
}
uint firstOfRow(uint row) { return kEnvironmentRows + row * kEnvironmentColumns; }

// A range of a cumulative distribution, in units of 2^-32.
struct SkyRange {
  uint index;  // of the element
  uint start, width;
};

// Returns the range of element `index` of `count` elements that begin at `first`.
SkyRange skyRange(uint64_t table, uint first, uint count, uint index) {
  uint start = sceneWordAt(table, first + index);
  uint next = index + 1u < count ? sceneWordAt(table, first + index + 1u) : 0u;  // the end, 2^32, wraps to 0
  return SkyRange(index, start, next - start);
}

// Returns the range that `u` is in. `count` is a power of two.
SkyRange skyRangeAt(uint64_t table, uint first, uint count, uint u) {
  uint index = 0u;
  for (uint step = count / 2u; step > 0u; step /= 2u)
    if (sceneWordAt(table, first + index + step) <= u) index += step;
  return skyRange(table, first, count, index);
}

// Returns where `u` is in its range, in [0, 1).
float withinRange(SkyRange range, uint u) {
  return min((float(u - range.start) + 0.5) / float(range.width), 1.0 - 1.0 / 16777216.0);
}

// The density in a cell, 1/sr. Its solid angle is a difference of cosines, as a product of sines: those of the rows
// near the poles differ by less than their rounding.
float skyDensity(SkyRange row, SkyRange column) {
  const float kUnit = 1.0 / 4294967296.0;
  const float kRow = kPi / float(kEnvironmentRows), kColumn = 2.0 * kPi / float(kEnvironmentColumns);
  float solidAngle = kColumn * 2.0 * sin((float(row.index) + 0.5) * kRow) * sin(0.5 * kRow);
  return (float(row.width) * kUnit) * (float(column.width) * kUnit) / solidAngle;
}

bool hasCells(RayScene scene, FrameConstants frame) {
  return kEnvironment != kEnvironmentNone && frame.environmentIntensity != 0.0 && scene.environment != 0ul;
}

vec3 skyRadiance(FrameConstants frame, vec3 direction) {
  vec2 uv = equirectangular(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
  return textureLod(SKY_PICTURE, uv, 0.0).rgb * frame.environmentIntensity;
}

// Returns the density with which sampleSky() returns a direction, in 1/sr.
float skyDensity(FrameConstants frame, RayScene scene, vec3 direction) {
  vec2 uv = equirectangular(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
  uvec2 cells = uvec2(kEnvironmentColumns, kEnvironmentRows);
  uvec2 cell = min(uvec2(vec2(fract(uv.x), uv.y) * vec2(cells)), cells - 1u);
  uint64_t table = skyTable(frame, scene);
  return skyDensity(skyRange(table, 0u, kEnvironmentRows, cell.y),
                    skyRange(table, firstOfRow(cell.y), kEnvironmentColumns, cell.x));
}

struct SkySample {
  vec3 direction;
  float density;  // 1/sr
};

// Returns a direction for a point of the unit square, times 2^32.
SkySample sampleSky(FrameConstants frame, RayScene scene, uvec2 u) {
  uint64_t table = skyTable(frame, scene);
  SkyRange row = skyRangeAt(table, 0u, kEnvironmentRows, u.y);
  SkyRange column = skyRangeAt(table, firstOfRow(row.index), kEnvironmentColumns, u.x);
  float top = float(row.index), rows = float(kEnvironmentRows);
  float z = mix(cos(kPi * top / rows), cos(kPi * (top + 1.0) / rows), withinRange(row, u.y));
  float across = (float(column.index) + withinRange(column, u.x)) / float(kEnvironmentColumns);
  float turn = (across - 0.5) * 2.0 * kPi, radius = sqrt(max(1.0 - z * z, 0.0));
  vec3 own = vec3(radius * cos(turn), -radius * sin(turn), z);
  vec3 direction = rotateToEnvironment(own, frame.environmentCos, -frame.environmentSin);
  return SkySample(direction, skyDensity(row, column));
}

#endif
