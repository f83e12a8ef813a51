// The instances of a scene in draw order (draw indices), numbered so that every triangle has a 32-bit id for the
// visibility buffer.
#pragma once

#include <vector>

#include "render/gpu_scene/buffer.h"
#include "render/visibility/compute/raster_push.h"
#include "render/visibility/draw_order.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

class RasterInstances {
 public:
  explicit RasterInstances(vk::Device& device)
      : list_(device, "instances in order"),
        drawIndexOfPart_(device, "instances of parts"),
        lists_(device, "instance list"),
        firstTriangles_(device, "first triangles of instances"),
        templates_(device, "instances in order, of all worlds") {}
  // Follows the scene and uploads changes with `uploader`. Does nothing if no instance or material has changed.
  void update(const GpuScene& scene, const DrawOrder& order, vk::Uploader& uploader);

  // The address of shared::InstanceList: opaque and masked instances, then blended ones.
  VkDeviceAddress address() const { return lists_.address(); }
  // The address of the records of a world, shared::RasterInstance[].
  VkDeviceAddress address(uint32_t world) const {
    return list_.address() + uint64_t{world} * all_.count * sizeof(shared::RasterInstance);
  }
  // RasterInstance::firstTriangle by index in FrameConstants::instances, uint32_t[].
  VkDeviceAddress firstTriangles() const { return firstTriangles_.address(); }
  // If shaders place the instances of worlds: the scene's records, which they complete, shared::RasterInstance[].
  VkDeviceAddress templates() const { return templates_.address(); }
  std::span<const shared::RasterInstance> records() const { return records_; }  // of the scene, or of all worlds
  // A prefix of the instances: solid() are the opaque and masked ones, all() includes the blended ones. If worlds have
  // their own materials, both are all instances, and only the flags of RasterInstance tell which are blended.
  struct Share {
    uint32_t count = 0;                         // instances
    bool anyOpaque = false, anyMasked = false;  // masked or blended
    uint64_t parts = 0;                         // total parts of kRasterGroup triangles
    bool operator==(const Share&) const = default;
  };
  bool mixesBlended() const { return mixed_; }  // solid() includes blended instances
  const Share& solid() const { return solid_; }
  const Share& all() const { return all_; }
  bool anyBlended() const { return anyBlended_; }
  const VisibleMaterials& materials() const { return visibleMaterials_; }
  // Number of triangle ids before those of the blended instances.
  uint32_t solidTriangles() const { return mixed_ ? 0 : static_cast<uint32_t>(solid_.parts * shared::kRasterGroup); }

 private:
  void add(const GpuScene& scene, uint32_t instance);
  void addDerived(const GpuScene& scene);
  void addWorlds(const GpuScene& scene);
  void upload(const GpuScene& scene, vk::Uploader& uploader);

  std::vector<shared::RasterInstance> records_;  // with worlds, those of each world
  std::vector<uint32_t> partDrawIndices_;
  GpuList<shared::RasterInstance> list_;
  GpuList<uint32_t> drawIndexOfPart_;
  GpuList<shared::InstanceList> lists_;  // a single element
  GpuList<uint32_t> firstTriangles_;
  GpuList<shared::RasterInstance> templates_;
  Share solid_, all_;
  bool mixed_ = false, anyBlended_ = false;
  VisibleMaterials visibleMaterials_;
  uint64_t instances_ = 0, materials_ = 0, worlds_ = 0;  // revisions of the last update
};

}  // namespace latelight::render
