#include "render/gpu_scene/object_frames.h"

#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <tuple>

#include "scene/curvature.h"

namespace latelight::render {

namespace {

shared::ObjectFrame recordOf(const scene::RestFrame& frame, glm::vec3 vertexOrigin, VkDeviceAddress positions,
                             VkDeviceAddress curvatures) {
  const glm::dmat4 fromVertex = glm::translate(frame.objectFromMesh, glm::dvec3(vertexOrigin));
  const double diagonal = frame.box.empty() ? 0 : glm::length(frame.box.high - frame.box.low);
  const glm::dvec3 center = frame.box.empty() ? glm::dvec3(0) : 0.5 * (frame.box.low + frame.box.high);
  return {.objectFromVertex = glm::mat4x3(fromVertex),
          .fromCenter = glm::vec3(glm::dvec3(fromVertex[3]) - center),
          .inverseDiagonal = diagonal > 0 ? static_cast<float>(1 / diagonal) : 0.0f,
          .positions = positions,
          .curvatures = curvatures};
}

// The shape of a mesh in its object's frame: the squared lengths and the products of the frame's axes, which rotations
// do not change, and whether it is mirrored.
using ShapeKey = std::tuple<uint32_t, std::array<float, 6>, bool>;

ShapeKey shapeOf(uint32_t mesh, const glm::dmat3& linear) {
  const auto product = [&](int i, int j) { return static_cast<float>(glm::dot(linear[i], linear[j])); };
  return {mesh,
          {product(0, 0), product(1, 1), product(2, 2), product(0, 1), product(0, 2), product(1, 2)},
          glm::determinant(linear) < 0};
}

}  // namespace

// Returns the address of each instance's curvatures.
std::vector<VkDeviceAddress> GpuObjectFrames::uploadCurvatures(vk::Uploader& uploader,
                                                               const std::vector<scene::RestFrame>& frames) {
  std::map<ShapeKey, size_t> firstOf;  // index of the shape's first value
  std::vector<glm::vec2> values;
  std::vector<size_t> first(frames.size(), 0);
  for (size_t i = 0; i < frames.size(); ++i) {
    const scene::Instance& instance = scene_.instances[i];
    if (instance.removed) continue;
    const glm::dmat3 linear(frames[i].objectFromMesh);
    const auto [shape, isNew] = firstOf.try_emplace(shapeOf(instance.mesh, linear), values.size());
    first[i] = shape->second;
    if (!isNew) continue;
    const std::vector<glm::vec2> some = scene::vertexCurvatures(scene_.meshes[instance.mesh], linear);
    values.insert(values.end(), some.begin(), some.end());
  }
  if (values.empty()) return std::vector<VkDeviceAddress>(frames.size(), 0);
  curvatures_.upload(uploader, values);
  std::vector<VkDeviceAddress> addresses;
  for (const size_t index : first) addresses.push_back(curvatures_.address() + index * sizeof(glm::vec2));
  return addresses;
}

void GpuObjectFrames::update(vk::Uploader& uploader, const GpuGeometry& geometry, bool curvatures) {
  const uint64_t meshes = scene_.edits.meshes.revision(), instances = scene_.edits.instances.revision();
  if (meshes == meshes_ && instances == instances_ && hasCurvatures_ >= curvatures) return;
  const std::vector<scene::RestFrame> frames = scene::restFrames(scene_);
  std::vector<shared::ObjectFrame> records(frames.size());
  std::vector<VkDeviceAddress> curvaturesOf(frames.size(), 0);
  if (curvatures) curvaturesOf = uploadCurvatures(uploader, frames);
  for (size_t i = 0; i < frames.size(); ++i) {
    const uint32_t mesh = scene_.instances[i].mesh;
    if (scene_.instances[i].removed) continue;
    records[i] =
        recordOf(frames[i], scene::vertexOrigin(scene_.meshes[mesh]), geometry.restPositions(mesh), curvaturesOf[i]);
  }
  if (!records.empty()) list_.upload(uploader, records);
  hasCurvatures_ = curvatures;
  meshes_ = meshes;
  instances_ = instances;
}

}  // namespace latelight::render
