// Direct lighting of a surface, shared by the techniques that loop over light lists.
//
// Each lane of a subgroup first tests one light against the bounding box of the subgroup's surfaces. Then all lanes
// shade the lights that passed, which are broadcast one by one. A light thus costs one load and one test per subgroup
// instead of per pixel: on lavapipe a load by address is a loop over lanes, and both sides of a branch are always
// executed.
#ifndef LATELIGHT_LIGHTS_GLSL
#define LATELIGHT_LIGHTS_GLSL
#include "render/glsl/lanes.glsl"
#include "render/glsl/one_light.glsl"
#include "shared/light.h"

Light broadcastLight(Light l, uint lane) {
  Light r;
  r.position = fromLane(l.position, lane);
  r.inverseRadius2 = fromLane(l.inverseRadius2, lane);
  r.intensity = fromLane(l.intensity, lane);
  r.type = fromLane(l.type, lane);
  r.direction = fromLane(l.direction, lane);
  r.spotScale = fromLane(l.spotScale, lane);
  r.spotOffset = fromLane(l.spotOffset, lane);
  return r;
}

LightShadow broadcastShadow(LightShadow s, uint lane) {
  return LightShadow(fromLane(s.first, lane), fromLane(s.maps, lane), fromLane(s.sun, lane));
}

// Returns true if the light may reach into the box.
bool reaches(Light l, vec3 low, vec3 high) {
  vec3 d = max(max(low - l.position, l.position - high), vec3(0.0));
  return lightIsDirectional(l.type) || dot(d, d) < l.radius * l.radius;
}

// Shared state of the lanes that shade together, and each lane's surface.
struct Shading {
  Surface s;
  LIT_BRDF brdf;
  uint view;
  bool lit;        // this lane has a surface
  vec3 low, high;  // bounding box of the surfaces of all lit lanes: findBounds()
  vec3 radiance;   // accumulated radiance towards the eye
};

Shading startShading(Surface s, LIT_BRDF brdf, uint view, bool lit) {
  return Shading(s, brdf, view, lit, vec3(0.0), vec3(0.0), vec3(0.0));
}

void findBounds(inout Shading shading) {
  const float kFar = 3.0e38;
  shading.low = subgroupMin(shading.lit ? shading.s.position : vec3(kFar));
  shading.high = subgroupMax(shading.lit ? shading.s.position : vec3(-kFar));
}

const uint64_t kAllLights = uint64_t(0);  // a list of all local lights

// Returns the index of element i of a light list (uint[] by address, or kAllLights).
uint lightOfList(FrameConstants frame, uint64_t list, uint i) {
  uint light = frame.directionalLights + i;
  if (list != kAllLights) light = UintRef(list).v[i];
  return light;
}

// A light that one lane contributes.
struct LaneLight {
  uint index;
  Light light;
  LightShadow shadow;
};

LaneLight laneLight(FrameConstants frame, uint view, uint index) {
  return LaneLight(index, frameLight(frame, index), shadowOf(frame, view, index));
}

// Returns a lane's light to all lanes. On GPUs a uniform load is cheaper than a dozen broadcasts.
Light lightOfLane(FrameConstants frame, LaneLight own, uint lane) {
  if (kCpuDevice != 0u) return broadcastLight(own.light, lane);
  return frameLight(frame, fromLane(own.index, lane));
}

// Adds the reflected radiance of one light, which is the same for all lanes.
void addLight(inout Shading shading, LightSample arriving) {
  float used = lightsUsed;
  vec3 sent = shadeUnshadowed(arriving, shading.brdf);
  if (shading.lit)
    shading.radiance += sent;
  else
    lightsUsed = used;
}

// Adds the reflected radiance of one light with its shadows.
void addShadowed(inout Shading shading, FrameConstants frame, Light light, LightSample arriving, LightShadow shadow) {
  float used = lightsUsed;
  vec3 sent = shadeShadowed(frame, light, arriving, shadow, shading.s, shading.brdf);
  if (shading.lit)
    shading.radiance += sent;
  else
    lightsUsed = used;
}

// The loop tests at the end: lavapipe executes the body once more if a loop tests at the beginning.
void shadeHits(inout Shading shading, FrameConstants frame, LaneLight own, uvec4 hits, bool shadowed) {
  if (!anyLane(hits)) return;
  do {
    uint lane = popLane(hits);
    Light light = lightOfLane(frame, own, lane);
    LightSample arriving = sampleLight(light, shading.s.position);
    if (shadowed)
      addShadowed(shading, frame, light, arriving, broadcastShadow(own.shadow, lane));
    else
      addLight(shading, arriving);
  } while (anyLane(hits));
}

// Each lane contributes a light. All lanes shade the lights with `hit`, in lane order: first those without shadows,
// then, in a separate loop, those with shadows. (lavapipe executes both sides of a branch; with a separate loop, a
// subgroup without shadowed lights executes the lookups at most once, not once per light.)
void shadeLaneLights(inout Shading shading, FrameConstants frame, LaneLight own, bool hit) {
  bool shadowed = kShadowFormat != kShadowNone && own.shadow.maps != 0u;
  shadeHits(shading, frame, own, subgroupBallot(hit && !shadowed), false);
  if (kShadowFormat != kShadowNone) shadeHits(shading, frame, own, subgroupBallot(hit && shadowed), true);
}

// Shades the lights [first, end) of the frame.
void shadeRange(inout Shading shading, FrameConstants frame, uint first, uint end) {
  if (first >= end) return;
  do {
    uint index = first + laneRank;
    LaneLight own = laneLight(frame, shading.view, min(index, end - 1u));
    shadeLaneLights(shading, frame, own, index < end && reaches(own.light, shading.low, shading.high));
    first += lanesPresent;
  } while (first < end);
}

// Returns the radiance that `s` reflects towards the eye from all lights of the frame. Every invocation of the subgroup
// must call it; `lit` is false for invocations without a surface.
vec3 shadeAllLights(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf, bool lit) {
  if (kLights == 0u) return vec3(0.0);
  lightsTested += float(frame.lightCount);
  countLanes();
  Shading shading = startShading(s, brdf, view, lit);
  findBounds(shading);
  shadeRange(shading, frame, 0u, frame.lightCount);
  return shading.radiance;
}

// As shadeAllLights(), but every invocation loads each light. This is the reference, and the fallback for devices
// without subgroup operations in fragment shaders.
vec3 shadeAllLightsPlainly(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf) {
  lightsTested += float(frame.lightCount);
  vec3 radiance = vec3(0.0);
  for (uint i = 0u; i < frame.lightCount; ++i)
    radiance += shadeOneLight(frame, frameLight(frame, i), shadowOf(frame, view, i), s, brdf);
  return radiance;
}

#endif
