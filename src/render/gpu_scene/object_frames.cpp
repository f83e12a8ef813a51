#include "render/gpu_scene/object_frames.h"

#include <glm/gtc/matrix_transform.hpp>

#include "scene/objects.h"

namespace latelight::render {

namespace {

shared::ObjectFrame recordOf(const scene::RestFrame& frame, glm::vec3 vertexOrigin, VkDeviceAddress positions) {
  const glm::dmat4 fromVertex = glm::translate(frame.objectFromMesh, glm::dvec3(vertexOrigin));
  const double diagonal = frame.box.empty() ? 0 : glm::length(frame.box.high - frame.box.low);
  const glm::dvec3 center = frame.box.empty() ? glm::dvec3(0) : 0.5 * (frame.box.low + frame.box.high);
  return {.objectFromVertex = glm::mat4x3(fromVertex),
          .fromCenter = glm::vec3(glm::dvec3(fromVertex[3]) - center),
          .inverseDiagonal = diagonal > 0 ? static_cast<float>(1 / diagonal) : 0.0f,
          .positions = positions};
}

}  // namespace

void GpuObjectFrames::update(vk::Uploader& uploader, const GpuGeometry& geometry) {
  const uint64_t meshes = scene_.edits.meshes.revision(), instances = scene_.edits.instances.revision();
  if (meshes == meshes_ && instances == instances_) return;
  meshes_ = meshes;
  instances_ = instances;
  const std::vector<scene::RestFrame> frames = scene::restFrames(scene_);
  std::vector<shared::ObjectFrame> records(frames.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    const uint32_t mesh = scene_.instances[i].mesh;
    if (scene_.instances[i].removed) continue;
    records[i] = recordOf(frames[i], scene::vertexOrigin(scene_.meshes[mesh]), geometry.restPositions(mesh));
  }
  if (!records.empty()) list_.upload(uploader, records);
}

}  // namespace latelight::render
