// Clusters of a mesh.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "shared/cluster.h"

namespace latelight::scene {

// As shared/cluster.h describes them.
struct Clusters {
  std::vector<shared::Cluster> clusters;
  std::vector<uint32_t> vertices;
  std::vector<shared::ClusterTriangle> triangles;
  std::vector<uint32_t> clusterOfTriangle;
};

// Of all of its triangles, which are halved until each cluster has its own, so that those of a cluster lie together
// whatever order the mesh has them in. (meshoptimizer's buildMeshlets gives spheres that are an eighth to a third
// larger, does not say which triangle is which, and takes five times as long for the hall.)
Clusters clustersOf(const Mesh& mesh);

}  // namespace latelight::scene
