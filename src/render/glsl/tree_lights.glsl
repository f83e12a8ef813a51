// Lights at a surface straight from the light tree, without lists: for what lies elsewhere than the surfaces of which lists
// are made. The cost is bounded by the lights that reach the surfaces, and lights come in the order in which all
// techniques sum them. After lights.glsl.
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

// Radiance that all of the frame's lights send from `s` to the eye. Every invocation of the subgroup must call it, for the
// same view; `lit` is false for those without a surface.
vec3 shadeAllByTree(FrameConstants frame, uint view, Surface s, LIT_BRDF brdf, bool lit) {
  countLanes();
  lightsTested += float(frame.directionalLights);
  Shading shading = startShading(s, brdf, view, lit);
  shadeRange(shading, frame, 0u, frame.directionalLights);
  shadeTree(shading, frame);  // a loop of its own: with one for both, blended surfaces took an H200 4 % longer
  return shading.radiance;
}

#endif
