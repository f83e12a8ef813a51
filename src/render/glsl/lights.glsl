// Lights at a surface, shared by the techniques that loop over lists of them.
//
// Lanes of a subgroup first test one light each against the box around all their surfaces, then all shade the lights
// that passed, each handed over by a broadcast. So a light costs a load and a test once a subgroup, not once a pixel:
// on lavapipe a load by address is a loop over lanes, and both sides of a branch always run.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "render/glsl/setup.glsl"
#include "shared/shade.h"

// For --debug lights: how many lights this pixel went through, and how many of them sent it anything.
float lightsTested = 0.0;
float lightsUsed = 0.0;
vec4 lightCount() { return vec4(lightsTested, lightsUsed, 0.0, 0.0); }

// Radiance that one light sends from `s` to the eye.
vec3 shadeOneLight(Light light, Surface s, vec3 toEye) {
  vec3 radiance = shadeLight(s, toEye, sampleLight(light, s.position), kShading);
  if (kCountLights != 0u && any(greaterThan(radiance, vec3(0.0)))) lightsUsed += 1.0;
  return radiance;
}

Light broadcastLight(Light l, uint lane) {
  Light r;
  r.position = subgroupBroadcast(l.position, lane);
  r.reach = subgroupBroadcast(l.reach, lane);
  r.direction = subgroupBroadcast(l.direction, lane);
  r.type = subgroupBroadcast(l.type, lane);
  r.intensity = subgroupBroadcast(l.intensity, lane);
  r.spotScale = subgroupBroadcast(l.spotScale, lane);
  r.spotOffset = subgroupBroadcast(l.spotOffset, lane);
  return r;
}

// Whether the light may reach into the box.
bool reaches(Light l, vec3 low, vec3 high) {
  vec3 d = max(max(low - l.position, l.position - high), vec3(0.0));
  return l.type == kLightDirectional || dot(d, d) < l.reach * l.reach;
}

// Radiance that all of the frame's lights send from `s` to the eye. Every invocation of the subgroup must call it;
// `lit` is false for those without a surface.
vec3 shadeAllLights(FrameConstants frame, Surface s, vec3 toEye, bool lit) {
  lightsTested += float(frame.lightCount);
  const float kFar = 3.0e38;
  vec3 low = subgroupMin(lit ? s.position : vec3(kFar));
  vec3 high = subgroupMax(lit ? s.position : vec3(-kFar));
  vec3 radiance = vec3(0.0);
  // Lights are dealt to the lanes that are there: a subgroup need not be full.
  uvec4 present = subgroupBallot(true);
  uint lanes = subgroupBallotBitCount(present);
  uint rank = subgroupBallotExclusiveBitCount(present);
  for (uint first = 0u; first < frame.lightCount; first += lanes) {
    uint index = first + rank;
    Light mine = frameLight(frame, min(index, frame.lightCount - 1u));
    uvec4 hits = subgroupBallot(index < frame.lightCount && reaches(mine, low, high));
    while (any(notEqual(hits, uvec4(0u)))) {
      uint lane = subgroupBallotFindLSB(hits);
      hits[lane >> 5u] &= ~(1u << (lane & 31u));
      Light light = broadcastLight(mine, lane);
      radiance += shadeOneLight(light, s, toEye);
    }
  }
  return radiance;
}
