// Lights at a surface, shared by the techniques that loop over lists of them.
//
// Lanes of a subgroup first test one light each against the box around all their surfaces, then all shade the lights
// that passed, each handed over by a broadcast. So a light costs a load and a test once a subgroup, not once a pixel:
// on lavapipe a load by address is a loop over lanes, and both sides of a branch always run.
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

// Whether the light may reach into the box.
bool reaches(Light l, vec3 low, vec3 high) {
  vec3 d = max(max(low - l.position, l.position - high), vec3(0.0));
  return lightIsDirectional(l.type) || dot(d, d) < l.radius * l.radius;
}

// What the lanes of a subgroup that shade together have in common, and each lane's own surface.
struct Shading {
  Surface s;
  LIT_BRDF brdf;
  uint view;
  bool lit;        // this lane takes part
  vec3 low, high;  // around the surfaces of those that do: findBounds()
  vec3 radiance;   // what lights have sent to the eye so far
};

Shading startShading(Surface s, LIT_BRDF brdf, uint view, bool lit) {
  return Shading(s, brdf, view, lit, vec3(0.0), vec3(0.0), vec3(0.0));
}

void findBounds(inout Shading shading) {
  const float kFar = 3.0e38;
  shading.low = subgroupMin(shading.lit ? shading.s.position : vec3(kFar));
  shading.high = subgroupMax(shading.lit ? shading.s.position : vec3(-kFar));
}

// A light that a lane brings.
struct DealtLight {
  uint index;
  Light light;
  LightShadow shadow;
};

DealtLight dealtLight(FrameConstants frame, uint view, uint index) {
  return DealtLight(index, frameLight(frame, index), shadowOf(frame, view, index));
}

// What a lane brought, for all. On GPUs a load that all lanes share costs less than a dozen broadcasts.
Light lightOfLane(FrameConstants frame, DealtLight mine, uint lane) {
  if (kCpuDevice != 0u) return broadcastLight(mine.light, lane);
  return frameLight(frame, fromLane(mine.index, lane));
}

// Adds what the surface sends to the eye of one light, which is the same for all lanes.
void addLight(inout Shading shading, LightSample arriving) {
  float used = lightsUsed;
  vec3 sent = shadeUnshadowed(arriving, shading.brdf);
  if (shading.lit)
    shading.radiance += sent;
  else
    lightsUsed = used;
}

// The same where something may stand between them.
void addShadowed(inout Shading shading, FrameConstants frame, Light light, LightSample arriving, LightShadow shadow) {
  float used = lightsUsed;
  vec3 sent = shadeShadowed(frame, light, arriving, shadow, shading.s, shading.brdf);
  if (shading.lit)
    shading.radiance += sent;
  else
    lightsUsed = used;
}

// Tested at the end of a round: lavapipe goes once more through a loop that ends at its beginning.
void shadeHits(inout Shading shading, FrameConstants frame, DealtLight mine, uvec4 hits, bool shadowed) {
  if (!anyLane(hits)) return;
  do {
    uint lane = popLane(hits);
    Light light = lightOfLane(frame, mine, lane);
    LightSample arriving = sampleLight(light, shading.s.position);
    if (shadowed)
      addShadowed(shading, frame, light, arriving, broadcastShadow(mine.shadow, lane));
    else
      addLight(shading, arriving);
  } while (anyLane(hits));
}

// Each lane brings a light; those that hit are shaded by all lanes, in the order of the lanes: first those without
// shadows, then, in a loop of their own, those that have some. (On lavapipe both sides of a branch run, but a loop of a
// subgroup without such lights runs its lookups once at most, not once a light.)
void shadeDealt(inout Shading shading, FrameConstants frame, DealtLight mine, bool hit) {
  bool shadowed = kShadowFormat != kShadowNone && mine.shadow.maps != 0u;
  shadeHits(shading, frame, mine, subgroupBallot(hit && !shadowed), false);
  if (kShadowFormat != kShadowNone) shadeHits(shading, frame, mine, subgroupBallot(hit && shadowed), true);
}

// The lights [first, end) of the frame.
void shadeRange(inout Shading shading, FrameConstants frame, uint first, uint end) {
  if (first >= end) return;
  do {
    uint index = first + laneRank;
    DealtLight mine = dealtLight(frame, shading.view, min(index, end - 1u));
    shadeDealt(shading, frame, mine, index < end && reaches(mine.light, shading.low, shading.high));
    first += lanesPresent;
  } while (first < end);
}

// Radiance that all of the frame's lights send from `s` to the eye. Every invocation of the subgroup must call it;
// `lit` is false for those without a surface.
vec3 shadeAllLights(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf, bool lit) {
  if (kLights == 0u) return vec3(0.0);
  lightsTested += float(frame.lightCount);
  countLanes();
  Shading shading = startShading(s, brdf, view, lit);
  findBounds(shading);
  shadeRange(shading, frame, 0u, frame.lightCount);
  return shading.radiance;
}

// The same, each light loaded by every invocation: the reference, and for devices whose fragment shaders have no
// subgroups.
vec3 shadeAllLightsPlainly(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf) {
  lightsTested += float(frame.lightCount);
  vec3 radiance = vec3(0.0);
  for (uint i = 0u; i < frame.lightCount; ++i)
    radiance += shadeOneLight(frame, frameLight(frame, i), shadowOf(frame, view, i), s, brdf);
  return radiance;
}

#endif
