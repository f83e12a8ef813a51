// Shading from the light tree: without light lists, for surfaces that the lists do not cover, or after a list. The cost
// is bounded by the lights that reach the surfaces. Lights are summed in the same order as in all techniques. Include
// after lights.glsl.
#ifndef LATELIGHT_TREE_LIGHTS_GLSL
#define LATELIGHT_TREE_LIGHTS_GLSL
#include "render/glsl/light_tree.glsl"

// Shades all local lights that the tree finds near the surfaces, in the order of the lights.
void shadeTree(inout Shading shading, FrameConstants frame) {
  TreeWalk walk = startWalk(frame, shading.low, shading.high, true);
  uint leaf;
  while (nextLeaf(walk, frame, leaf)) {
    uint end = min(leaf + kLightTreeWidth, frame.lightCount);
    if (shading.lit) lightsTested += float(end - leaf);
    shadeRange(shading, frame, leaf, end);
  }
}

// Shades the frame's directional lights, then `count` lights of a list (lightOfList()), then, if `walks` is true, all
// local lights that the tree finds near the surfaces; each part in the order of the lights. All parts share one
// loop: shading a light is most of a shader's code, which lavapipe compiles for each call, and entering a loop costs
// more there than an iteration.
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
    if (there && listed && light >= frame.directionalLights)
      light = lightOfList(frame, list, light - frame.directionalLights);
    LaneLight own = laneLight(frame, shading.view, light);
    shadeLaneLights(shading, frame, own, there && reaches(own.light, shading.low, shading.high));
    next += lanesPresent;
    if (next < end) continue;
    listed = false;  // continue with a leaf of the tree
    if (!nextLeaf(walk, frame, next)) break;
    end = min(next + kLightTreeWidth, frame.lightCount);
    if (shading.lit) lightsTested += float(end - next);
  }
}

// Returns the radiance that `s` reflects towards the eye from all lights of the frame. Every invocation of the subgroup
// must call it for the same view; `lit` is false for invocations without a surface.
vec3 shadeAllByTree(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf, bool lit) {
  if (kLights == 0u) return vec3(0.0);
  if (kFewLights != 0u) return shadeAllLights(frame, view, s, brdf, lit);
  countLanes();
  Shading shading = startShading(s, brdf, view, lit);
  findBounds(shading);
  if (kCpuDevice != 0u) {
    shadeNear(shading, frame, uint64_t(0), 0u, true);
  } else {  // separate loops: one for both is slower on GPUs
    lightsTested += float(frame.directionalLights);
    shadeRange(shading, frame, 0u, frame.directionalLights);
    shadeTree(shading, frame);
  }
  return shading.radiance;
}

#endif
