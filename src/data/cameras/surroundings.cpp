#include "data/cameras/surroundings.h"

#include <array>
#include <cmath>
#include <map>

#include "base/parallel.h"
#include "scene/exact_math.h"

namespace latelight::data {

using glm::dmat4, glm::dvec3, glm::dvec4;

namespace {

using Triangle = std::array<dvec3, 3>;

// Bytes per triangle in a BVH and in the list of boxes that it is built from.
constexpr uint64_t kTriangleBytes = 48 + 4 + 36;

dvec3 at(const dmat4& transform, dvec3 point) {
  return dvec3(transform * dvec4(point, 1));
}

Triangle triangleOf(const scene::Mesh& mesh, uint32_t number) {
  const uint32_t* index = &mesh.indices[size_t{3} * number];
  return {dvec3(mesh.positions[index[0]]), dvec3(mesh.positions[index[1]]), dvec3(mesh.positions[index[2]])};
}

std::unique_ptr<Bvh> treeOf(const scene::Mesh& mesh) {
  std::vector<Aabb> boxes(mesh.indices.size() / 3);
  for (uint32_t i = 0; i < boxes.size(); ++i)
    for (const dvec3& corner : triangleOf(mesh, i)) boxes[i].add(corner);
  return std::make_unique<Bvh>(boxes);
}

// Returns the distance to the nearest point of a triangle, found by the Voronoi region of the triangle's feature that
// contains the point (Ericson 2005, Real-Time Collision Detection, 5.1.5).
double distanceTo(const Triangle& t, dvec3 p) {
  const dvec3 ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0], bp = p - t[1], cp = p - t[2];
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
               d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return glm::length(ap);
  if (d3 >= 0 && d4 <= d3) return glm::length(bp);
  if (d6 >= 0 && d5 <= d6) return glm::length(cp);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(ap - ab * (d1 / (d1 - d3)));
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(ap - ac * (d2 / (d2 - d6)));
  if (va <= 0 && d4 >= d3 && d5 >= d6) return glm::length(bp - (t[2] - t[1]) * ((d4 - d3) / (d4 - d3 + d5 - d6)));
  const double sum = va + vb + vc;
  return glm::length(ap - ab * (vb / sum) - ac * (vc / sum));
}

// Returns a ray's contribution to the winding number: 1 if it leaves through the triangle's back, -1 if it enters
// through its front, and 0 if it misses. The test is watertight: the sign of each edge is computed from its ends in one
// order, so a ray through an edge hits only one of the two triangles (Woop, Benthin and Wald 2013, "Watertight
// ray/triangle intersection").
int crossing(const Triangle& t, dvec3 origin, dvec3 direction) {
  const dvec3 a = t[0] - origin, b = t[1] - origin, c = t[2] - origin;
  const auto side = [&](dvec3 p, dvec3 q) {
    const bool swapped = p.x != q.x ? p.x > q.x : p.y != q.y ? p.y > q.y : p.z > q.z;
    const double volume = swapped ? -glm::dot(glm::cross(q, p), direction) : glm::dot(glm::cross(p, q), direction);
    return volume != 0 ? volume > 0 : swapped;
  };
  const bool ab = side(a, b), bc = side(b, c), ca = side(c, a);
  if (ab != bc || bc != ca) return 0;
  const dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double along = glm::dot(normal, direction);
  if (along == 0 || glm::dot(normal, a) / along < 0) return 0;
  return along > 0 ? 1 : -1;
}

// Ray directions on a Fibonacci grid, evenly distributed over the sphere; none is parallel to an axis.
constexpr int kRays = 15;
dvec3 rayDirection(int ray) {
  const double z = (2 * ray + 1.0) / kRays - 1;
  return dvec3(exact::onCircle(0.1 + 0.6180339887498949 * ray) * std::sqrt(1 - z * z), z);
}

}  // namespace

struct Surroundings::Piece {
  uint32_t instance = 0;
  dmat4 toFile{1}, toObject{1};
  // A lower bound of the ratio of distances in the file's frame to those in object space. 0 if the transform is
  // singular; the instance is then flat and has no interior.
  double leastScale = 0;
};

Surroundings::~Surroundings() = default;

Surroundings::Surroundings(const scene::Scene& scene) : meshes_(scene.meshes.size()), scene_(scene) {
  std::vector<bool> used(scene.meshes.size());
  for (const scene::Instance& instance : scene.instances)
    if (isShown(scene, {}, instance)) used[instance.mesh] = true;
  for (size_t i = 0; i < used.size(); ++i)
    if (used[i]) memory_.grow(scene.meshes[i].indices.size() / 3 * kTriangleBytes, "the search for free places");
  parallelFor(meshes_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (used[i]) meshes_[i] = treeOf(scene.meshes[i]);
  });
  std::vector<Aabb> boxes;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const scene::Instance& instance = scene.instances[i];
    if (!isShown(scene, {}, instance) || scene.meshes[instance.mesh].indices.empty()) continue;
    pieces_.push_back(pieceOf(i));
    const Aabb local = meshes_[instance.mesh]->bounds();
    Aabb& box = boxes.emplace_back();
    for (int corner = 0; corner < 8; ++corner)
      box.add(
          at(pieces_.back().toFile, {corner & 1 ? local.high.x : local.low.x, corner & 2 ? local.high.y : local.low.y,
                                     corner & 4 ? local.high.z : local.low.z}));
  }
  tree_ = std::make_unique<Bvh>(boxes);
}

Surroundings::Piece Surroundings::pieceOf(uint32_t instance) const {
  Piece piece{.instance = instance, .toFile = scene_.instances[instance].toWorld};
  if (scene_.yUp) piece.toFile = scene::toGltfFromWorld() * piece.toFile;
  if (glm::determinant(glm::dmat3(piece.toFile)) == 0) return piece;
  piece.toObject = glm::inverse(piece.toFile);
  double squares = 0;  // for the Frobenius norm of toObject, an upper bound of its largest scale
  for (int axis = 0; axis < 3; ++axis) squares += glm::dot(dvec3(piece.toObject[axis]), dvec3(piece.toObject[axis]));
  piece.leastScale = 1 / std::sqrt(squares);
  return piece;
}

bool Surroundings::inside(dvec3 point) const {
  std::map<uint32_t, int> windings;  // by node, summed over all rays
  for (int ray = 0; ray < kRays; ++ray) {
    const dvec3 direction = rayDirection(ray);
    const auto addPiece = [&](uint32_t number) {
      const Piece& piece = pieces_[number];
      if (piece.leastScale == 0) return;
      const scene::Instance& instance = scene_.instances[piece.instance];
      const scene::Mesh& mesh = scene_.meshes[instance.mesh];
      // Front faces are counterclockwise in object space, even if the transform mirrors.
      const dvec3 origin = at(piece.toObject, point), along(piece.toObject * dvec4(direction, 0));
      int& winding = windings[instance.node];
      meshes_[instance.mesh]->visit([&](const Aabb& box) { return box.meets(origin, 1.0 / along); },
                                    [&](uint32_t t) { winding += crossing(triangleOf(mesh, t), origin, along); });
    };
    tree_->visit([&](const Aabb& box) { return box.meets(point, 1.0 / direction); }, addPiece);
  }
  return std::ranges::any_of(windings, [](const auto& node) { return 2 * node.second > kRays; });
}

double Surroundings::nearest(dvec3 point, double limit) const {
  double least = limit;
  const auto searchPiece = [&](uint32_t number) {
    const Piece& piece = pieces_[number];
    const uint32_t meshNumber = scene_.instances[piece.instance].mesh;
    const dvec3 local = at(piece.toObject, point);
    meshes_[meshNumber]->visit(
        // The tolerance allows for rounding.
        [&](const Aabb& box) { return box.distance(local) * piece.leastScale <= least * (1 + 1e-9); },
        [&](uint32_t t) {
          Triangle triangle = triangleOf(scene_.meshes[meshNumber], t);
          for (dvec3& corner : triangle) corner = at(piece.toFile, corner);
          least = std::min(least, distanceTo(triangle, point));
        });
  };
  tree_->visit([&](const Aabb& box) { return box.distance(point) <= least * (1 + 1e-9); }, searchPiece);
  return least;
}

}  // namespace latelight::data
