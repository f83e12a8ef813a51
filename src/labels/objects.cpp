#include "labels/objects.h"

#include <algorithm>
#include <map>

#include "base/parallel.h"
#include "scene/file_frame.h"
#include "scene/objects.h"

namespace latelight::labels {

namespace {

using Instances = std::vector<uint32_t>;

std::array<double, 12> rowsOf(const glm::dmat4& m) {
  std::array<double, 12> rows;
  for (int i = 0; i < 12; ++i) rows[static_cast<size_t>(i)] = m[i % 4][i / 4];
  return rows;
}

std::vector<glm::vec3> deformedVertices(const scene::Scene& scene, const scene::Deformation& deformation,
                                        const scene::Pose& pose) {
  std::vector<glm::mat4> joints;
  if (deformation.skin >= 0)
    joints = scene::jointMatrices(scene.rig.skins[static_cast<size_t>(deformation.skin)], pose);
  std::vector<float> weights;
  if (deformation.weightsNode >= 0) weights = pose.weights[static_cast<size_t>(deformation.weightsNode)];
  return scene::deform(deformation, joints, weights).positions;
}

class Boxes {
 public:
  Boxes(const scene::Scene& scene, const scene::Pose& pose, bool zUp, const PlacedInstances& placed,
        const MeshVertices& vertices, const std::vector<uint64_t>* geometry)
      : scene_(scene),
        frames_(scene),
        pose_(pose),
        geometry_(geometry),
        toWorld_(placed.toWorld),
        vertices_(vertices),
        fromWorld_(zUp ? glm::dmat4(1) : scene::fileFromWorld(scene)) {}

  Object around(uint32_t id, const Instances& instances) const {
    Object object{.id = id};
    object.toWorld =
        scene::rigidOf(fromWorld_ * frames_.toWorld(pose_, toWorld_, instances), frames_.scaleSigns(instances));
    scene::Extent extent;
    for (const uint32_t i : instances) {
      const glm::dmat4 place = glm::inverse(object.toWorld) * fromWorld_ * toWorld_[i];
      add(extent, object.shape, scene_.instances[i], place);
    }
    object.low = extent.low;
    object.high = extent.high;
    const glm::dvec3 size = extent.high - extent.low;
    object.shape.extent = std::max({size.x, size.y, size.z});
    return object;
  }

 private:
  // Adds an instance to the object's box, and to its shape if shapes are requested.
  void add(scene::Extent& extent, Shape& shape, const scene::Instance& instance, const glm::dmat4& toFrame) const {
    const scene::Mesh& mesh = scene_.meshes[instance.mesh];
    if (mesh.positions.empty()) return;
    if (geometry_) shape.parts.push_back({(*geometry_)[instance.mesh], rowsOf(toFrame)});
    const auto addAll = [&](const std::vector<glm::vec3>& points) {
      for (const glm::vec3 point : points) extent.add(glm::dvec3(toFrame * glm::dvec4(point, 1)));
    };
    if (const auto own = vertices_.find(instance.mesh); own != vertices_.end()) {
      addAll(own->second);
    } else if (mesh.deformation && !pose_.empty()) {
      const std::vector<glm::vec3> points = deformedVertices(scene_, *mesh.deformation, pose_);
      if (geometry_) shape.parts.back().geometry = geometryHash(points, mesh.indices);
      addAll(points);
    } else {
      scene::addMesh(extent, mesh, toFrame);
    }
  }

  const scene::Scene& scene_;
  scene::ObjectFrames frames_;
  const scene::Pose& pose_;
  const std::vector<uint64_t>* geometry_;   // hashes by mesh; null if shapes are not requested
  const std::vector<glm::dmat4>& toWorld_;  // world transforms by instance
  const MeshVertices& vertices_;
  glm::dmat4 fromWorld_;
};

}  // namespace

std::array<glm::dvec3, 8> cornersOf(const Object& object) {
  std::array<glm::dvec3, 8> corners;
  for (size_t i = 0; i < 8; ++i)
    corners[i] = {(i & 1) != 0 ? object.high.x : object.low.x, (i & 2) != 0 ? object.high.y : object.low.y,
                  (i & 4) != 0 ? object.high.z : object.low.z};
  return corners;
}

PlacedInstances placedInstances(const scene::Scene& scene, const scene::Pose& pose) {
  return {scene::instanceTransforms(scene, pose), {}};
}

PlacedInstances placedInstances(const scene::Scene& scene, const scene::Pose& pose, const render::WorldStates& worlds,
                                uint32_t world) {
  PlacedInstances placed = placedInstances(scene, pose);
  const bool empty = !worlds.empty.empty() && worlds.empty[world] != 0;
  placed.exists.assign(scene.instances.size(), empty ? 0 : 1);
  const size_t first = world * worlds.instances.size();
  for (size_t i = 0; i < worlds.instances.size(); ++i) {
    const uint32_t instance = worlds.instances[i];
    if (!worlds.transforms.empty()) placed.toWorld[instance] = worlds.transforms[first + i];
    if (!worlds.exists.empty() && worlds.exists[first + i] == 0) placed.exists[instance] = 0;
  }
  return placed;
}

MeshVertices deformedVertices(const scene::Scene& scene, const scene::Pose& pose, const render::WorldStates& worlds,
                              uint32_t world) {
  const render::WorldDeformations& given = worlds.deformations;
  MeshVertices vertices;
  if (!worlds.empty.empty() && worlds.empty[world] != 0) return vertices;
  if (!given.joints.empty()) {
    const scene::Pose posed = given.poseIn(world, scene, pose);
    for (uint32_t mesh = 0; mesh < scene.meshes.size(); ++mesh)
      if (given.poses(scene, mesh)) vertices[mesh] = deformedVertices(scene, *scene.meshes[mesh].deformation, posed);
  }
  for (size_t i = 0; i < given.meshes.size(); ++i) vertices[given.meshes[i]] = given.verticesIn(world, scene, i);
  return vertices;
}

namespace {

using Groups = std::vector<std::pair<uint32_t, Instances>>;  // instances by id

Groups groupsOf(const scene::Scene& scene, const scene::Pose& pose, const PlacedInstances& placed) {
  std::map<uint32_t, Instances> byId;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const scene::Instance& instance = scene.instances[i];
    if (placed.has(i) && isShown(scene, pose, instance) && !scene.meshes[instance.mesh].positions.empty())
      byId[instance.id].push_back(i);
  }
  return {byId.begin(), byId.end()};
}

std::vector<Object> objectsAround(const Boxes& boxes, const Groups& groups) {
  std::vector<Object> objects(groups.size());
  parallelFor(groups.size(), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) objects[i] = boxes.around(groups[i].first, groups[i].second);
  });
  return objects;
}

}  // namespace

std::vector<Object> objectsOf(const scene::Scene& scene, const scene::Pose& pose, bool zUp,
                              const PlacedInstances& placed, const MeshVertices& vertices) {
  return objectsAround(Boxes(scene, pose, zUp, placed, vertices, nullptr), groupsOf(scene, pose, placed));
}

std::vector<Object> objectsOf(const scene::Scene& scene, const scene::Pose& pose, bool zUp, GeometryHashes* geometry) {
  const PlacedInstances placed = placedInstances(scene, pose);
  if (!geometry) return objectsOf(scene, pose, zUp, placed, {});
  const Groups groups = groupsOf(scene, pose, placed);
  std::vector<uint64_t> hashes(scene.meshes.size());
  for (const auto& [id, instances] : groups)
    for (const uint32_t i : instances) hashes[scene.instances[i].mesh] = geometry->of(scene, scene.instances[i].mesh);
  const MeshVertices none;
  return objectsAround(Boxes(scene, pose, zUp, placed, none, &hashes), groups);
}

}  // namespace latelight::labels
