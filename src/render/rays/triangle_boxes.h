// The boxes of a mesh's triangles, from which the host builds its BVH.
#pragma once

#include <cstdint>
#include <vector>

#include "render/rays/bvh.h"
#include "scene/scene.h"

namespace latelight::render {

struct TriangleBoxes {
  std::vector<Box> boxes;
  std::vector<uint32_t> triangles;  // of each box; empty: each triangle has one box, in the order of the mesh
};

// Returns boxes in the mesh's space on the device. Long triangles that lie diagonally waste space in their boxes. If a
// fifth more boxes, which divide the worst ones, reduce the boxes' total area by at least a quarter, triangles have
// several boxes, which together contain them. Those of skins and morphs are whole, because a refit would make them so.
TriangleBoxes triangleBoxes(const scene::Mesh& mesh);

}  // namespace latelight::render
