// The object frames of instances at rest (shared/object_frame.h) in device memory, in the scene's order.
#pragma once

#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/geometry.h"
#include "scene/objects.h"
#include "scene/scene.h"
#include "shared/object_frame.h"

namespace latelight::render {

class GpuObjectFrames {
 public:
  GpuObjectFrames(vk::Device& device, const scene::Scene& scene)
      : scene_(scene), list_(device, "object frames"), curvatures_(device, "curvatures") {}
  // Uploads the frames if instances or meshes were edited since the last call. `curvatures`: also those of vertices.
  void update(vk::Uploader& uploader, const GpuGeometry& geometry, bool curvatures);
  VkDeviceAddress address() const { return list_.address(); }  // shared::ObjectFrame[]; 0 before update()

 private:
  std::vector<VkDeviceAddress> uploadCurvatures(vk::Uploader& uploader, const std::vector<scene::RestFrame>& frames);

  const scene::Scene& scene_;
  uint64_t meshes_ = ~uint64_t{0}, instances_ = ~uint64_t{0};  // revisions
  bool hasCurvatures_ = false;
  GpuList<shared::ObjectFrame> list_;
  GpuList<glm::vec2> curvatures_;  // of the vertices of each mesh, once per shape that instances give it
};

}  // namespace latelight::render
