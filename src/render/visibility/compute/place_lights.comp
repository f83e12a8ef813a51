#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the lights of a world, with one workgroup per world: those that emit light, in the order of the light tree,
// the boxes of the tree, the area lights, their numbers, the rays to lights with shadows by rays, and which of the
// lights have shadow maps. The host's counterparts are makeLightSet(), buildLightTree(), FrameShadows::uploadRays() and
// FrameShadows::number(). A world has at most kMaxPlacedLights lights, so all boxes of its tree are leaves.
#include "render/visibility/compute/place_worlds.glsl"
#include "render/gpu_scene/view_constants_push.h"
#include "shared/color.h"
#include "shared/light.h"
#include "shared/rays.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer LightsOut { Light v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer AreaLightsOut { AreaLight v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer BoxesOut { LightBox v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValuesOut { WorldValues v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer RayShadowsOut { RayShadow v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer CastersOut { PlacedCaster v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer BitsOut { ShadowBits v[]; };

// Keys by which lights are sorted: directional lights come first, and lights that emit nothing last.
const uint64_t kLocal = 1ul << 62, kDark = 1ul << 63;

shared uint64_t keys[kMaxPlacedLights];
shared vec3 positions[kMaxPlacedLights];
shared LightBox boxes[kMaxPlacedLights];  // of the sorted lights
shared uint emitting[kMaxPlacedLights];   // area lights
shared uint casting[kMaxPlacedLights];    // lights that emit light and cast shadows, by rays or maps
shared uint castingBits[kMaxPlacedLights / 32u];  // the same of the sorted lights, as bits

// The values of a template that a world may change.
struct PlacedLight {
  uint variant;  // index in LightTemplate::light
  vec3 position, direction, intensity;
};

dvec3 pointAt(WorldJob job, uint index, uint which) {
  DoublesRef from = DoublesRef(job.lightPositions + uint64_t(index * kLightPositions + 3u * which) * 8ul);
  return dvec3(from.v[0], from.v[1], from.v[2]);
}

dvec3 triple(WorldNumbers n, uint row) {
  return dvec3(numberAt(n, 3u * row), numberAt(n, 3u * row + 1u), numberAt(n, 3u * row + 2u));
}

vec3 scaled(vec3 color, float intensity) {
  precise vec3 product = color * intensity;
  return product;
}

// The direction in the renderer's world, as unitDirection() of the host.
vec3 worldDirection(WorldJob job, vec3 given) {
  dvec3 direction = widened(given);
  double lengthOf = sqrt(dotOf(direction, direction));
  precise dvec3 unit = direction / lengthOf;
  dmat4 m = columnsAt(job.matrices, kWorldFromFile);
  dvec3 v = roundedToFloat(unit);
  precise dvec3 turned = m[0].xyz * v.x + m[1].xyz * v.y + m[2].xyz * v.z;
  return vec3(turned);
}

// Lights with a node follow it unless the world moves them.
PlacedLight placedLight(WorldJob job, uint world, uint index) {
  LightTemplate t = LightTemplates(job.lightTemplates).v[index];
  bool listed = t.listed != kNowhere && !isInvalid(job, world);
  uint row = listed ? world * job.listedLights + t.listed : 0u;
  dvec3 atRest = pointAt(job, index, 0u), position = atRest;
  vec3 directionAtRest = t.light[0].direction, direction = directionAtRest;
  if (listed && job.lightPosition.address != 0ul) {
    dvec3 given = triple(job.lightPosition, row);
    if (given != pointAt(job, index, 2u)) position = transformed(columnsAt(job.matrices, kWorldFromFile), given).xyz;
  }
  if (listed && job.lightDirection.address != 0ul) {
    vec3 given = vec3(triple(job.lightDirection, row));
    if (given != t.fileDirection && given != vec3(0.0)) direction = worldDirection(job, given);
  }
  bool moved = position != atRest || direction != directionAtRest;
  PlacedLight placed;
  placed.variant = (t.state & kLightHasNode) != 0u && !moved ? 1u : 0u;
  if (placed.variant == 1u) {
    position = pointAt(job, index, 1u);
    direction = t.light[1].direction;
  }
  placed.position = vec3(difference(position, columnsAt(job.matrices, kDeviceOrigin)[0].xyz));
  placed.direction = direction;
  vec3 color = t.color;
  float intensity = t.intensity;
  if (listed && job.lightColor.address != 0ul) color = vec3(triple(job.lightColor, row));
  if (listed && job.lightIntensity.address != 0ul) intensity = float(numberAt(job.lightIntensity, row));
  placed.intensity = scaled(color, intensity);
  return placed;
}

bool isFinite(vec3 v) { return !any(isnan(v)) && !any(isinf(v)); }

Light punctual(WorldJob job, uint index, PlacedLight placed) {
  Light light = LightTemplates(job.lightTemplates).v[index].light[placed.variant];
  light.position = placed.position;
  light.direction = placed.direction;
  light.intensity = placed.intensity;
  return light;
}

bool emits(Light light) {
  return isFinite(light.position) && isFinite(light.direction) && isFinite(light.intensity) && light.radius > 0.0 &&
         maxChannel(light.intensity) > 0.0;
}

// --- light tree ------------------------------------------------------------------------------------------------------

LightBox emptyBox() {
  float infinity = uintBitsToFloat(0x7f800000u);
  return LightBox(vec3(infinity), vec3(-infinity));
}

uint64_t spread(uint64_t x) {
  x = (x | x << 32) & 0x001f00000000fffful;
  x = (x | x << 16) & 0x001f0000ff0000fful;
  x = (x | x << 8) & 0x100f00f00f00f00ful;
  x = (x | x << 4) & 0x10c30c30c30c30c3ul;
  return (x | x << 2) & 0x1249249249249249ul;
}

// A position along the Morton curve over the cube around all local lights.
uint64_t mortonCode(vec3 position, LightBox around) {
  precise vec3 size = around.high - around.low;
  float extent = maxChannel(size), most = float((1u << kLightAxisBits) - 1u), scale = 0.0;
  if (extent > 0.0 && !isinf(extent)) scale = float(double(most) / double(extent));  // correctly rounded
  uint64_t code = 0ul;
  for (uint i = 0u; i < 3u; ++i) {
    precise float along = (position[i] - around.low[i]) * scale;
    code |= spread(uint64_t(uint(clamp(along, 0.0, most)))) << i;
  }
  return code;
}

// The bounds of a light's reach, as lightBox() of the host, where angles replace the cosines of their sums.
LightBox boxOf(Light light) {
  vec3 extent[2] = vec3[2](vec3(1.0), vec3(1.0));  // toward + and -, in radii
  if (lightHasCone(light.type)) {
    double outer = clamp(-double(light.spotOffset) / double(light.spotScale), -1.0lf, 1.0lf);
    double outerSine = sqrt(1.0lf - outer * outer);
    for (uint i = 0u; i < 6u; ++i) {
      double axis = clamp(widened(i < 3u ? light.direction[i] : -light.direction[i - 3u]), -1.0lf, 1.0lf);
      double nearest = axis * outer + sqrt(1.0lf - axis * axis) * outerSine;
      extent[i / 3u][i % 3u] = axis >= outer ? 1.0 : float(nearest);
    }
  }
  vec3 slack = abs(light.position) * 1e-6;
  for (uint i = 0u; i < 6u; ++i) {
    float reach = extent[i / 3u][i % 3u];
    extent[i / 3u][i % 3u] = reach > -5e-4 ? (reach + 5e-4) * light.radius : 0.0;
  }
  return LightBox(light.position - extent[1] - slack, light.position + extent[0] + slack);
}

// The bounds of the positions of all local lights that emit light.
LightBox boundsOfPositions(uint lights) {
  LightBox box = emptyBox();
  for (uint i = 0u; i < lights; ++i)
    if ((keys[i] & kDark) == 0ul && (keys[i] & kLocal) != 0ul)
      box = LightBox(min(box.low, positions[i]), max(box.high, positions[i]));
  return box;
}

void writeAreaLight(WorldJob job, uint world, uint index) {
  PlacedLight placed = placedLight(job, world, index);
  AreaLight light = LightTemplates(job.lightTemplates).v[index].area[placed.variant];
  light.center = placed.position;
  light.radiance = placed.intensity;
  uint rank = 0u;
  for (uint i = 0u; i < index; ++i) rank += emitting[i];
  if (emitting[index] != 0u) AreaLightsOut(job.areaLights).v[world * job.lights + rank] = light;
}

// --- steps -----------------------------------------------------------------------------------------------------------

// Finds out which lights emit light.
void listLights(WorldJob job, uint world) {
  for (uint i = gl_LocalInvocationIndex; i < job.lights; i += kPlaceGroup) {
    LightTemplate t = LightTemplates(job.lightTemplates).v[i];
    PlacedLight placed = placedLight(job, world, i);
    keys[i] = kDark;
    emitting[i] = casting[i] = 0u;
    positions[i] = placed.position;
    if ((t.state & kLightIsArea) != 0u) {
      bool shines = isFinite(placed.position) && isFinite(placed.intensity) && maxChannel(placed.intensity) > 0.0;
      emitting[i] = shines && (t.state & kLightHasExtent) != 0u ? 1u : 0u;
    } else if (emits(punctual(job, i, placed))) {
      keys[i] = lightIsDirectional(t.light[0].type) ? 0ul : kLocal;
      casting[i] = (t.state & kLightCastsByRays) != 0u || t.mapCaster != kNowhere ? 1u : 0u;
    }
  }
  for (uint i = gl_LocalInvocationIndex; i < kMaxPlacedLights / 32u; i += kPlaceGroup) castingBits[i] = 0u;
}

void keyLights(WorldJob job, LightBox around) {
  for (uint i = gl_LocalInvocationIndex; i < job.lights; i += kPlaceGroup) {
    if (keys[i] != kLocal) continue;
    uint64_t radius = uint64_t(LightTemplates(job.lightTemplates).v[i].radiusClass);
    keys[i] |= radius << (3u * kLightAxisBits) | mortonCode(positions[i], around);
  }
}

void writeCaster(WorldJob job, uint world, uint caster, PlacedCaster placed) {
  CastersOut(job.placedCasters).v[world * job.mapCasters + caster] = placed;
}

// Writes each light to its place among the sorted ones.
void sortLights(WorldJob job, uint world) {
  for (uint i = gl_LocalInvocationIndex; i < job.lights; i += kPlaceGroup) {
    LightTemplate t = LightTemplates(job.lightTemplates).v[i];
    if (emitting[i] != 0u) writeAreaLight(job, world, i);
    if (keys[i] == kDark && t.mapCaster != kNowhere)
      writeCaster(job, world, t.mapCaster, PlacedCaster(vec3(0.0), kEmitsNothing, vec3(0.0, 0.0, -1.0), 0u));
    if (keys[i] == kDark) continue;
    uint rank = 0u, column = 0u;
    for (uint other = 0u; other < job.lights; ++other) {
      bool before = keys[other] < keys[i] || (keys[other] == keys[i] && other < i);
      rank += before ? 1u : 0u;
      column += before ? casting[other] : 0u;
    }
    Light light = punctual(job, i, placedLight(job, world, i));
    boxes[rank] = boxOf(light);
    LightsOut(job.lightList).v[world * job.lights + rank] = light;
    if (t.mapCaster != kNowhere) {
      writeCaster(job, world, t.mapCaster, PlacedCaster(light.position, column, light.direction, 0u));
      atomicOr(castingBits[rank / 32u], 1u << (rank % 32u));
    }
    if (job.casters == 0u) continue;
    if (casting[i] != 0u) {
      RayShadowsOut(job.rayShadows).v[world * job.casters + column] = RayShadow(rank, t.shadowRays, t.shadowSize, 0u);
      light.intensity = vec3(0.0);
    }
    LightsOut(job.otherLights).v[world * job.lights + rank] = light;
  }
}

// Lights that emit nothing in this world leave elements at the end of its list.
void endRayShadows(WorldJob job, uint world) {
  uint count = 0u;
  for (uint i = 0u; i < job.lights; ++i) count += casting[i];
  for (uint i = count + gl_LocalInvocationIndex; i < job.casters; i += kPlaceGroup)
    RayShadowsOut(job.rayShadows).v[world * job.casters + i] = RayShadow(kRayNone, 0u, 0.0, 0u);
}

void writeShadowBits(WorldJob job, uint world) {
  uint words = (job.lights + 31u) / 32u;
  for (uint word = gl_LocalInvocationIndex; word < words; word += kPlaceGroup) {
    uint before = 0u;
    for (uint i = 0u; i < word; ++i) before += bitCount(castingBits[i]);
    BitsOut(job.shadowBits).v[world * words + word] = ShadowBits(castingBits[word], before);
  }
}

void main() {
  WorldJob job = JobRef(push.job).v;
  uint world = workgroupIndex();
  if (world >= job.worlds) return;
  listLights(job, world);
  barrier();
  LightBox around = boundsOfPositions(job.lights);
  barrier();
  keyLights(job, around);
  barrier();
  sortLights(job, world);
  endRayShadows(job, world);
  uint directional = 0u, local = 0u, area = 0u;
  for (uint i = 0u; i < job.lights; ++i) {
    directional += keys[i] < kLocal ? 1u : 0u;
    local += keys[i] >= kLocal && keys[i] < kDark ? 1u : 0u;
    area += emitting[i];
  }
  barrier();
  if (job.mapCasters > 0u) writeShadowBits(job, world);
  for (uint leaf = gl_LocalInvocationIndex; leaf < kPlacedLightBoxes; leaf += kPlaceGroup) {
    LightBox box = emptyBox();
    for (uint i = leaf * kLightTreeWidth; i < min(local, (leaf + 1u) * kLightTreeWidth); ++i)
      box = LightBox(min(box.low, boxes[directional + i].low), max(box.high, boxes[directional + i].high));
    BoxesOut(job.lightBoxes).v[world * kPlacedLightBoxes + leaf] = box;
  }
  if (gl_LocalInvocationIndex != 0u) return;
  ValuesOut(job.values).v[world].lightCount = directional + local;
  ValuesOut(job.values).v[world].directionalLights = directional;
  ValuesOut(job.values).v[world].lightTreeLeaves = 0u;
  ValuesOut(job.values).v[world].areaLightCount = area;
}
