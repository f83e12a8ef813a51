// Lights of a short list at the surfaces of a subgroup, for GPUs, where lanes that all load a light load it once. Nearly
// all lights of such a list reach the surfaces, and to find out which do not takes longer than to shade with them. Of
// compute shaders with a pixel an invocation. After lights.glsl.
#ifndef LATELIGHT_LISTED_LIGHTS_GLSL
#define LATELIGHT_LISTED_LIGHTS_GLSL
#include "render/glsl/meet_subgroup.glsl"
#include "render/pixel_group.h"

shared uint listedLights[kPixelGroupX * kPixelGroupY];

// Lights in the order of the lanes, those without shadows first.
struct ListedRound {
  uint light;  // this lane's
  uint count, unshadowed;
};

ListedRound listedRound(FrameConstants frame, uint view, uint light, uint count) {
  if (kShadowFormat == kShadowNone) return ListedRound(light, count, count);
  bool shadowed = shadowOf(frame, view, light).maps != 0u;
  uvec4 those = subgroupBallot(laneRank < count && shadowed);
  uint before = subgroupBallotExclusiveBitCount(those), unshadowed = count - subgroupBallotBitCount(those);
  uint base = gl_SubgroupID * gl_SubgroupSize;
  meetSubgroup();  // what was there has been read
  if (laneRank < count) listedLights[base + (shadowed ? unshadowed + before : laneRank - before)] = light;
  meetSubgroup();
  return ListedRound(listedLights[base + laneRank], count, unshadowed);
}

// The frame's directional lights, then `count` lights of a list (uint[] by address).
void shadeListed(inout Shading shading, FrameConstants frame, uint64_t list, uint count) {
  uint end = frame.directionalLights + count;
  if (shading.lit) lightsTested += float(end);
  for (uint first = 0u; first < end; first += lanesPresent) {
    uint light = min(first + laneRank, end - 1u);
    if (light >= frame.directionalLights) light = UintRef(list).v[light - frame.directionalLights];
    ListedRound round = listedRound(frame, shading.view, light, min(end - first, lanesPresent));
    for (uint i = 0u; i < round.unshadowed; ++i) {
      vec3 sent = sentBy(frame, frameLight(frame, fromLane(round.light, i)), LightShadow(0u, 0u, 0u), false, shading.s,
                         shading.brdf, shading.lit);
      if (shading.lit) shading.radiance += sent;
    }
    if (kShadowFormat == kShadowNone) continue;
    for (uint i = round.unshadowed; i < round.count; ++i) {
      uint one = fromLane(round.light, i);
      vec3 sent = sentBy(frame, frameLight(frame, one), shadowOf(frame, shading.view, one), true, shading.s, shading.brdf,
                         shading.lit);
      if (shading.lit) shading.radiance += sent;
    }
  }
}

#endif
