// A light tree: a bounding volume hierarchy (BVH) over lights, with which a shader finds the few of a million lights
// that reach a position (Olsson, Billeter and Assarsson 2012, Clustered Deferred and Forward Shading). buildLightTree()
// sorts local lights by size and along a Morton curve, which keeps neighbors together, and bounds groups of
// kLightTreeWidth lights and boxes up to the root. shared/types.h describes the memory layout; glsl/light_tree.glsl
// traverses the tree.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/types.h"

namespace latelight::render {

// Returns the bounds of a light's sphere, or of a spot's cone. They are never smaller than what sampleLight() lights.
shared::LightBox lightBox(const shared::Light& light);

// Returns the class of similar radii by which the tree orders lights first. Each class spans a factor of four, and the
// largest radii come first.
uint32_t radiusClass(float radius);

struct LightTree {
  std::vector<shared::Light> lights;    // directional lights in input order, then local lights
  std::vector<uint32_t> sources;        // index of each light in the input
  uint32_t directionalLights = 0;       // number of directional lights
  std::vector<shared::LightBox> nodes;  // at least the root's children
  uint32_t firstLeaf = 0;
};

// Builds the tree on all cores.
LightTree buildLightTree(const std::vector<shared::Light>& lights);

}  // namespace latelight::render
