// The instances of a scene in the order of drawing, numbered so that every triangle of them has an id of 32 bits: what
// the visibility buffer holds.
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
        rankOfPart_(device, "instances of parts"),
        lists_(device, "instance list") {}
  // Follows the scene; costs nothing where no instance has changed. What the device lacks is uploaded with `uploader`.
  void update(const GpuScene& scene, const DrawOrder& order, vk::Uploader& uploader);

  // shared::InstanceList: solid ones, then blended ones.
  VkDeviceAddress address() const { return lists_.address(); }
  // Of the solid ones, or of all of them.
  struct Share {
    uint32_t ranks = 0, masked = 0;  // instances; those whose alpha takes parts of them away
    uint64_t parts = 0;              // of kRasterGroup triangles, in all
  };
  const Share& solid() const { return solid_; }
  const Share& all() const { return all_; }
  bool anyBlended() const { return all_.ranks > solid_.ranks; }
  const ShownMaterials& materials() const { return materialsShown_; }
  // Numbers that those of the solid ones take, up to the first of the blended ones.
  uint32_t solidTriangles() const { return static_cast<uint32_t>(solid_.parts * shared::kRasterGroup); }

 private:
  std::vector<shared::RasterInstance> records_;
  std::vector<uint32_t> partRanks_;
  GpuList<shared::RasterInstance> list_;
  GpuList<uint32_t> rankOfPart_;
  GpuList<shared::InstanceList> lists_;  // one
  Share solid_, all_;
  ShownMaterials materialsShown_;
  uint64_t instances_ = 0, materials_ = 0;  // revisions that it follows
};

}  // namespace latelight::render
