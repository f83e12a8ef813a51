// Directions of the environment in proportion to their brightness, for rays: from the tables of cells that the scene's
// BVHs refer to (RayScene::environment). Define SKY_PICTURE, the environment's equirectangular image, before the
// include.
#ifndef LATELIGHT_SKY_SAMPLES_GLSL
#define LATELIGHT_SKY_SAMPLES_GLSL
#include "render/glsl/rays.glsl"
#include "render/glsl/setup.glsl"
#include "shared/environment.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CellsRef { EnvironmentCell v[]; };

// Returns true if the view has the environment of this index. Images of environments differ in size, so a pass samples
// one of them.
bool isOwnSky(FrameConstants frame, uint environment) {
  return kWorlds == 0u || (frame.environmentMap & kEnvironmentLayerMask) == environment;
}

// Returns the EnvironmentCell of an index. The tables of the environments of worlds follow each other.
EnvironmentCell skyCell(FrameConstants frame, RayScene scene, uint index) {
  uint64_t table = scene.environment;
  if (kWorlds != 0u) table += uint64_t(frame.environmentMap & kEnvironmentLayerMask) * kEnvironmentTableBytes;
  return CellsRef(table).v[index];
}

bool hasCells(RayScene scene, FrameConstants frame) {
  return kEnvironment != 0u && frame.environmentIntensity != 0.0 && scene.environment != 0ul;
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
  return skyCell(frame, scene, cell.y * kEnvironmentColumns + cell.x).density;
}

// Returns a direction. `u` selects the cell, and `inside` the direction in the cell; both are in [0, 1).
vec3 sampleSky(FrameConstants frame, RayScene scene, vec2 u, vec2 inside) {
  uint count = kEnvironmentColumns * kEnvironmentRows;
  uint index = min(uint(u.x * float(count)), count - 1u);
  EnvironmentCell cell = skyCell(frame, scene, index);
  if (u.y >= cell.threshold) index = cell.alias;
  float row = float(index / kEnvironmentColumns), rows = float(kEnvironmentRows);
  float z = mix(cos(kPi * row / rows), cos(kPi * (row + 1.0) / rows), inside.y);
  float across = (float(index % kEnvironmentColumns) + inside.x) / float(kEnvironmentColumns);
  float turn = (across - 0.5) * 2.0 * kPi, radius = sqrt(max(1.0 - z * z, 0.0));
  vec3 own = vec3(radius * cos(turn), -radius * sin(turn), z);
  return rotateToEnvironment(own, frame.environmentCos, -frame.environmentSin);
}

#endif
