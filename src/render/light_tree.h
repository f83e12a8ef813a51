// Lights in an order that keeps neighbours together, under a tree of boxes: what lets a shader find the few of a
// million lights that reach a place. shared/types.h says how the tree lies in memory, glsl/light_tree.glsl walks it.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/types.h"

namespace latelight::render {

// Where a light may reach: its sphere's box, for a spot its cone's. Never smaller than what sampleLight() lights.
shared::LightBox lightBox(const shared::Light& light);

struct LightTree {
  std::vector<shared::Light> lights;    // directional ones first, in the order they came; then the local ones
  std::vector<uint32_t> sources;        // of each, its place among those that came
  uint32_t directionalLights = 0;       // how many of them are directional
  std::vector<shared::LightBox> nodes;  // at least the root's children
  uint32_t firstLeaf = 0;
};

// On all cores: about half a second for a million lights on two.
LightTree buildLightTree(const std::vector<shared::Light>& lights);

}  // namespace latelight::render
