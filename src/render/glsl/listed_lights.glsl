// Shading from a short light list, for GPUs, where a load that is uniform in the subgroup is executed once. Nearly all
// lights of a short list reach the surfaces, so testing them costs more than shading with them. For compute shaders
// with one pixel per invocation. Include after lights.glsl.
#ifndef LATELIGHT_LISTED_LIGHTS_GLSL
#define LATELIGHT_LISTED_LIGHTS_GLSL
#include "render/glsl/subgroup_shared_barrier.glsl"
#include "render/base/pixel_group.h"

shared uint listedLights[kPixelGroupX * kPixelGroupY];

// One light per lane, reordered so that lights without shadows come first.
struct ListedRound {
  uint light;  // this lane's light
  uint count, unshadowed;
};

ListedRound listedRound(FrameConstants frame, uint view, uint light, uint count) {
  if (kShadowFormat == kShadowNone) return ListedRound(light, count, count);
  bool shadowed = shadowOf(frame, view, light).maps != 0u;
  uvec4 those = subgroupBallot(laneRank < count && shadowed);
  uint before = subgroupBallotExclusiveBitCount(those), unshadowed = count - subgroupBallotBitCount(those);
  uint base = gl_SubgroupID * gl_SubgroupSize;
  subgroupSharedBarrier();  // the previous round has been read
  if (laneRank < count) listedLights[base + (shadowed ? unshadowed + before : laneRank - before)] = light;
  subgroupSharedBarrier();
  return ListedRound(listedLights[base + laneRank], count, unshadowed);
}

// Light lists contain only local lights, so the loop has no branch on the light type.
void shadeRound(inout Shading shading, FrameConstants frame, ListedRound round) {
  for (uint i = 0u; i < round.unshadowed; ++i) {
    Light light = frameLight(frame, fromLane(round.light, i));
    addLight(shading, sampleLocalLight(light, shading.s.position));
  }
  if (kShadowFormat == kShadowNone) return;
  for (uint i = round.unshadowed; i < round.count; ++i) {
    uint index = fromLane(round.light, i);
    Light light = frameLight(frame, index);
    addShadowed(shading, frame, light, sampleLocalLight(light, shading.s.position),
                shadowOf(frame, shading.view, index));
  }
}

// Shades the frame's directional lights, then `count` lights of a list (lightOfList()).
void shadeListed(inout Shading shading, FrameConstants frame, uint64_t list, uint count) {
  if (shading.lit) lightsTested += float(frame.directionalLights + count);
  for (uint i = 0u; i < frame.directionalLights; ++i) {
    Light light = frameLight(frame, i);
    addShadowed(shading, frame, light, sampleLight(light, shading.s.position), shadowOf(frame, shading.view, i));
  }
  for (uint first = 0u; first < count; first += lanesPresent) {
    uint light = lightOfList(frame, list, min(first + laneRank, count - 1u));
    shadeRound(shading, frame, listedRound(frame, shading.view, light, min(count - first, lanesPresent)));
  }
}

#endif
