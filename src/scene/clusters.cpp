#include "scene/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <span>

#include "base/parallel.h"

namespace latelight::scene {

namespace {

// A triangle without an area faces no way: what there is left of it on screen may face any.
bool anyDegenerate(const Mesh& mesh, std::span<const uint32_t> indices) {
  for (size_t i = 0; i < indices.size(); i += 3) {
    const vec3 a = mesh.positions[indices[i]], b = mesh.positions[indices[i + 1]], c = mesh.positions[indices[i + 2]];
    if (glm::cross(b - a, c - a) == vec3(0)) return true;
  }
  return false;
}

shared::Cluster clusterOf(const Mesh& mesh, std::span<const uint32_t> indices) {
  vec3 low(mesh.positions[indices[0]]), high = low;
  for (const uint32_t i : indices) {
    low = glm::min(low, mesh.positions[i]);
    high = glm::max(high, mesh.positions[i]);
  }
  shared::Cluster cluster{.centre = 0.5f * low + 0.5f * high, .apex = vec3(0), .cutoff = 1, .axis = vec3(0)};
  for (const uint32_t i : indices)
    cluster.radius = std::max(cluster.radius, glm::distance(cluster.centre, mesh.positions[i]));
  if (anyDegenerate(mesh, indices)) return cluster;
  const meshopt_Bounds bounds = meshopt_computeClusterBounds(indices.data(), indices.size(), &mesh.positions[0].x,
                                                             mesh.positions.size(), sizeof(vec3));
  cluster.apex = {bounds.cone_apex[0], bounds.cone_apex[1], bounds.cone_apex[2]};
  cluster.axis = {bounds.cone_axis[0], bounds.cone_axis[1], bounds.cone_axis[2]};
  cluster.cutoff = bounds.cone_cutoff;
  return cluster;
}

}  // namespace

std::vector<shared::Cluster> clustersOf(const Mesh& mesh) {
  constexpr size_t kIndices = 3 * shared::kClusterTriangles, kAtOnce = 256;
  const std::span<const uint32_t> all(mesh.indices);
  std::vector<shared::Cluster> clusters((all.size() + kIndices - 1) / kIndices);
  parallelFor(clusters.size(), kAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      clusters[i] = clusterOf(mesh, all.subspan(i * kIndices, std::min(kIndices, all.size() - i * kIndices)));
  });
  return clusters;
}

}  // namespace latelight::scene
