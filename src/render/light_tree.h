// Lights in an order that keeps neighbours together, under a tree of boxes, with which a shader finds the few of a
// million lights that reach a position. shared/types.h describes the memory layout, glsl/light_tree.glsl walks the
// tree.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/types.h"

namespace latelight::render {

// Bounds of a light: of its sphere, or of a spot's cone. Never smaller than what sampleLight() lights.
shared::LightBox lightBox(const shared::Light& light);

struct LightTree {
  std::vector<shared::Light> lights;    // directional ones first, in input order; then the local ones
  std::vector<uint32_t> sources;        // of each, its index in the input
  uint32_t directionalLights = 0;       // how many of them are directional
  std::vector<shared::LightBox> nodes;  // at least the root's children
  uint32_t firstLeaf = 0;
};

// On all cores: about half a second for a million lights on two.
LightTree buildLightTree(const std::vector<shared::Light>& lights);

}  // namespace latelight::render
