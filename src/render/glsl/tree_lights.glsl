// Lights at a surface from the light tree: without lists, for what lies elsewhere than the surfaces of which lists are
// made, or after one. The cost is bounded by the lights that reach the surfaces, and lights come in the order in which
// all techniques sum them. After lights.glsl.
#ifndef LATELIGHT_TREE_LIGHTS_GLSL
#define LATELIGHT_TREE_LIGHTS_GLSL
#include "render/glsl/light_tree.glsl"

// All local lights that the tree has near the surfaces, in the order of the lights.
void shadeTree(inout Shading shading, FrameConstants frame) {
  TreeWalk walk = startWalk(frame, shading.low, shading.high, true);
  uint leaf;
  while (nextLeaf(walk, frame, leaf)) {
    uint end = min(leaf + kLightTreeWidth, frame.lightCount);
    if (shading.lit) lightsTested += float(end - leaf);
    shadeRange(shading, frame, leaf, end);
  }
}

// The frame's directional lights, then `count` lights of a list (uint[] by address), then, where `walks`, all local
// lights that the tree has near the surfaces; each part in the order of the lights. One loop for all: shading a light is
// most of a shader, and lavapipe compiles it wherever it stands, and takes more for a loop than for a round of it.
void shadeNear(inout Shading shading, FrameConstants frame, uint64_t list, uint count, bool walks) {
  TreeWalk walk = startWalk(frame, shading.low, shading.high, walks);
  uint next = 0u, end = frame.directionalLights + count;
  if (end == 0u && !walks) return;
  if (shading.lit) lightsTested += float(end);
  bool listed = true;
  while (true) {  // no test at the beginning (see shadeHits())
    uint light = next + laneRank;
    bool there = light < end;
    light = there ? light : 0u;
    if (there && listed && light >= frame.directionalLights) light = UintRef(list).v[light - frame.directionalLights];
    DealtLight mine = dealtLight(frame, shading.view, light);
    shadeDealt(shading, frame, mine, there && reaches(mine.light, shading.low, shading.high));
    next += lanesPresent;
    if (next < end) continue;
    listed = false;  // on to a leaf of the tree
    if (!nextLeaf(walk, frame, next)) break;
    end = min(next + kLightTreeWidth, frame.lightCount);
    if (shading.lit) lightsTested += float(end - next);
  }
}

// Radiance that all of the frame's lights send from `s` to the eye. Every invocation of the subgroup must call it, for the
// same view; `lit` is false for those without a surface.
vec3 shadeAllByTree(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf, bool lit) {
  if (kLights == 0u) return vec3(0.0);
  if (kFewLights != 0u) return shadeAllLights(frame, view, s, brdf, lit);
  countLanes();
  Shading shading = startShading(s, brdf, view, lit);
  findBounds(shading);
  if (kCpuDevice != 0u) {
    shadeNear(shading, frame, uint64_t(0), 0u, true);
  } else {  // each in a loop of its own: with one for both, blended surfaces took an H200 4 % longer
    lightsTested += float(frame.directionalLights);
    shadeRange(shading, frame, 0u, frame.directionalLights);
    shadeTree(shading, frame);
  }
  return shading.radiance;
}

#endif
