// Builds clusters (meshlets) of a mesh by recursive bisection of its triangles' centroids at the median of the longest
// axis, until each part fits into one cluster. All parts of a level are split in parallel. Each cluster then gets its
// list of unique vertices, its bounding sphere and box, and its normal cone for backface cone culling.
#include "scene/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "base/parallel.h"

namespace latelight::scene {

namespace {

using shared::kClusterTriangles;
using shared::kClusterVertices;

struct Placed {  // triangle index and centroid
  vec3 middle;
  uint32_t number;
};

std::vector<Placed> placed(const Mesh& mesh) {
  std::vector<Placed> triangles(mesh.indices.size() / 3);
  parallelFor(triangles.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t* corners = &mesh.indices[3 * i];
      const vec3 sum = mesh.positions[corners[0]] + mesh.positions[corners[1]] + mesh.positions[corners[2]];
      triangles[i] = {sum / 3.0f, static_cast<uint32_t>(i)};
    }
  });
  return triangles;
}

// Partitions triangles into two halves, the first a multiple of the cluster size, by the median along the longest axis
// of their centroids. Returns the size of the first half.
size_t halve(std::span<Placed> triangles) {
  vec3 low = triangles.front().middle, high = low;
  for (const Placed& t : triangles) {
    low = glm::min(low, t.middle);
    high = glm::max(high, t.middle);
  }
  const vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const size_t clusters = (triangles.size() + kClusterTriangles - 1) / kClusterTriangles;
  const size_t half = clusters / 2 * kClusterTriangles;
  std::nth_element(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(half), triangles.end(),
                   [axis](const Placed& a, const Placed& b) {
                     return std::pair(a.middle[axis], a.number) < std::pair(b.middle[axis], b.number);
                   });
  return half;
}

// Returns the triangles in cluster order.
std::vector<Placed> byCluster(const Mesh& mesh) {
  std::vector<Placed> triangles = placed(mesh);
  std::vector<std::span<Placed>> parts{triangles};
  while (!parts.empty()) {
    std::vector<std::span<Placed>> halves(2 * parts.size());
    parallelFor(parts.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        if (parts[i].size() <= kClusterTriangles) continue;
        const size_t half = halve(parts[i]);
        halves[2 * i] = parts[i].first(half);
        halves[2 * i + 1] = parts[i].subspan(half);
      }
    });
    std::erase_if(halves, [](const std::span<Placed>& part) { return part.size() <= kClusterTriangles; });
    parts = std::move(halves);
  }
  return triangles;
}

// A triangle without area has no orientation; its rounded screen-space position may face either direction.
bool anyDegenerate(const Mesh& mesh, std::span<const uint32_t> indices) {
  for (size_t i = 0; i < indices.size(); i += 3) {
    const vec3 a = mesh.positions[indices[i]], b = mesh.positions[indices[i + 1]], c = mesh.positions[indices[i + 2]];
    if (glm::cross(b - a, c - a) == vec3(0)) return true;
  }
  return false;
}

// Returns the bounds of a cluster with these triangle indices. A cutoff of 1 disables backface cone culling.
shared::Cluster boundsOf(const Mesh& mesh, std::span<const uint32_t> indices) {
  vec3 low(mesh.positions[indices[0]]), high = low;
  for (const uint32_t i : indices) {
    low = glm::min(low, mesh.positions[i]);
    high = glm::max(high, mesh.positions[i]);
  }
  shared::Cluster cluster{.center = 0.5f * low + 0.5f * high, .apex = vec3(0), .cutoff = 1, .axis = vec3(0)};
  for (size_t i = 0; i < indices.size(); ++i) {
    const vec3 corner = mesh.positions[indices[i]], next = mesh.positions[indices[i % 3 == 2 ? i - 2 : i + 1]];
    cluster.radius = std::max(cluster.radius, glm::distance(cluster.center, corner));
    cluster.extent = glm::max(cluster.extent, glm::abs(corner - cluster.center));
    cluster.edge = std::max(cluster.edge, glm::distance(corner, next));
  }
  if (anyDegenerate(mesh, indices)) return cluster;
  const meshopt_Bounds bounds = meshopt_computeClusterBounds(indices.data(), indices.size(), &mesh.positions[0].x,
                                                             mesh.positions.size(), sizeof(vec3));
  cluster.apex = {bounds.cone_apex[0], bounds.cone_apex[1], bounds.cone_apex[2]};
  cluster.axis = {bounds.cone_axis[0], bounds.cone_axis[1], bounds.cone_axis[2]};
  cluster.cutoff = bounds.cone_cutoff;
  return cluster;
}

// A set of vertices, as a hash table with open addressing. add() returns the vertex's index in the set.
class VertexSet {
 public:
  VertexSet() { table_.fill(kNone); }
  uint32_t add(uint32_t vertex) {
    uint32_t place = (vertex * 2654435761u) >> (32 - kBits);
    while (table_[place] != kNone && vertices_[table_[place]] != vertex) place = (place + 1) % table_.size();
    if (table_[place] == kNone) {
      table_[place] = static_cast<uint16_t>(count_);
      vertices_[count_++] = vertex;
    }
    return table_[place];
  }
  std::span<const uint32_t> all() const { return {vertices_.data(), count_}; }

 private:
  static constexpr uint32_t kBits = 10;
  static constexpr uint16_t kNone = 0xffff;
  std::array<uint16_t, 1 << kBits> table_;
  std::array<uint32_t, kClusterVertices> vertices_;
  uint32_t count_ = 0;
};

// Fills cluster `index`, and its vertices starting at kClusterVertices * index.
void build(const Mesh& mesh, std::span<const Placed> order, Clusters& all, size_t index) {
  const size_t first = index * kClusterTriangles, end = std::min(order.size(), first + kClusterTriangles);
  VertexSet set;
  std::array<uint32_t, 3 * kClusterTriangles> indices;
  for (size_t i = first; i < end; ++i) {
    const uint32_t* corners = &mesh.indices[3 * size_t{order[i].number}];
    std::copy_n(corners, 3, &indices[3 * (i - first)]);
    shared::ClusterTriangle& triangle = all.triangles[i];
    triangle.corners = set.add(corners[0]) | set.add(corners[1]) << 10 | set.add(corners[2]) << 20;
    triangle.number = order[i].number;
    all.clusterOfTriangle[order[i].number] = static_cast<uint32_t>(index);
  }
  std::ranges::copy(set.all(), &all.vertices[kClusterVertices * index]);
  all.clusters[index] = boundsOf(mesh, std::span(indices).first(3 * (end - first)));
  all.clusters[index].vertices = static_cast<uint32_t>(set.all().size());
}

// Compacts the vertex lists, so that each cluster's vertices directly follow the previous cluster's.
void closeUp(Clusters& all) {
  uint32_t next = 0;
  for (size_t i = 0; i < all.clusters.size(); ++i) {
    shared::Cluster& cluster = all.clusters[i];
    std::copy_n(&all.vertices[kClusterVertices * i], cluster.vertices, &all.vertices[next]);
    cluster.firstVertex = next;
    next += cluster.vertices;
  }
  all.vertices.resize(next);
}

}  // namespace

Clusters clustersOf(const Mesh& mesh) {
  const std::vector<Placed> order = byCluster(mesh);
  const size_t count = (order.size() + kClusterTriangles - 1) / kClusterTriangles;
  Clusters all{.clusters = std::vector<shared::Cluster>(count),
               .vertices = std::vector<uint32_t>(count * kClusterVertices),
               .triangles = std::vector<shared::ClusterTriangle>(order.size()),
               .clusterOfTriangle = std::vector<uint32_t>(order.size())};
  parallelFor(count, 64, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) build(mesh, order, all, i);
  });
  closeUp(all);
  return all;
}

}  // namespace latelight::scene
