// The object frames of instances at rest (shared/object_frame.h) in device memory, in the scene's order.
#pragma once

#include "render/gpu_scene/buffer.h"
#include "render/gpu_scene/geometry.h"
#include "scene/scene.h"
#include "shared/object_frame.h"

namespace latelight::render {

class GpuObjectFrames {
 public:
  GpuObjectFrames(vk::Device& device, const scene::Scene& scene) : scene_(scene), list_(device, "object frames") {}
  // Uploads the frames if instances or meshes were edited since the last call.
  void update(vk::Uploader& uploader, const GpuGeometry& geometry);
  VkDeviceAddress address() const { return list_.address(); }  // shared::ObjectFrame[]; 0 before update()

 private:
  const scene::Scene& scene_;
  uint64_t meshes_ = ~uint64_t{0}, instances_ = ~uint64_t{0};  // revisions
  GpuList<shared::ObjectFrame> list_;
};

}  // namespace latelight::render
