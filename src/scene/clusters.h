// Builds clusters (meshlets) of a mesh, which are culled and rasterized as units.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "shared/cluster.h"

namespace latelight::scene {

// The arrays that shared/cluster.h describes.
struct Clusters {
  std::vector<shared::Cluster> clusters;
  std::vector<uint32_t> vertices;
  std::vector<shared::ClusterTriangle> triangles;
  std::vector<uint32_t> clusterOfTriangle;
};

// Clusters all triangles of a mesh. Triangles are bisected recursively until each part is one cluster, so that a
// cluster's triangles are adjacent regardless of their order in the mesh. (meshoptimizer's buildMeshlets produces
// bounding spheres that are an eighth to a third larger, does not report the index of each triangle, and is five times
// slower for the hall.)
Clusters clustersOf(const Mesh& mesh);

}  // namespace latelight::scene
