// Clusters of a mesh.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "shared/cluster.h"

namespace latelight::scene {

// Of each shared::kClusterTriangles triangles in turn, as the indices have them.
std::vector<shared::Cluster> clustersOf(const Mesh& mesh);

}  // namespace latelight::scene
