// Lights at a surface, shared by the techniques that loop over lists of them.
//
// Lanes of a subgroup first test one light each against the box around all their surfaces, then all shade the lights
// that passed, each handed over by a broadcast. So a light costs a load and a test once a subgroup, not once a pixel:
// on lavapipe a load by address is a loop over lanes, and both sides of a branch always run.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "render/glsl/one_light.glsl"

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
  // Lights are dealt to the lanes that are there: a subgroup need not be full. In fragment shaders lavapipe's helper
  // invocations, whose loads give nothing, are not; others' take part and load.
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

// The same, each light loaded by every invocation: the reference, and for devices whose fragment shaders have no
// subgroups.
vec3 shadeAllLightsPlainly(FrameConstants frame, Surface s, vec3 toEye) {
  lightsTested += float(frame.lightCount);
  vec3 radiance = vec3(0.0);
  for (uint i = 0u; i < frame.lightCount; ++i) radiance += shadeOneLight(frameLight(frame, i), s, toEye);
  return radiance;
}
