#include "render/visibility/compute/ranks.h"

#include "base/error.h"

namespace latelight::render {

namespace {

uint32_t flagsOf(const shared::Instance& instance, const shared::Material& material) {
  uint32_t flags = 0;
  if (material.flags & shared::kMaterialDoubleSided) flags |= shared::kRankDoubleSided;
  if (instance.flags & shared::kInstanceMirrored) flags |= shared::kRankMirrored;
  if (material.flags & (shared::kMaterialMasked | shared::kMaterialBlended)) flags |= shared::kRankCutOut;
  if (material.flags & shared::kMaterialBlended) flags |= shared::kRankBlended;
  return flags;
}

}  // namespace

void InstanceRanks::update(const GpuScene& scene, const DrawOrder& order, vk::Uploader& uploader) {
  const GpuInstances& all = scene.instances();
  if (instances_ == all.revision() && materials_ == scene.materials().revision()) return;
  instances_ = all.revision();
  materials_ = scene.materials().revision();
  records_.clear();
  all_ = {};
  uint64_t triangles = 0;
  for (const DrawOrder::Kind kind : {DrawOrder::Kind::Solid, DrawOrder::Kind::Blended}) {
    for (const uint32_t instance : order.select(scene, kind, [](const Sphere&) { return true; }).instances) {
      const shared::Instance& record = all.record(instance);
      const Sphere& bounds = all.bounds(instance);
      const uint32_t count = scene.geometry().indexCount(record.mesh) / 3;
      const uint32_t flags = flagsOf(record, scene.materials().record(record.material));
      records_.push_back(
          {bounds.centre, bounds.radius, instance, record.mesh, static_cast<uint32_t>(triangles), count, flags});
      triangles += count;
      ++all_.ranks;
      all_.cutOut += (flags & shared::kRankCutOut) != 0;
      all_.parts += (count + shared::kRasterGroup - 1) / shared::kRasterGroup;
    }
    if (kind == DrawOrder::Kind::Solid) {
      solid_ = all_;
      solidTriangles_ = static_cast<uint32_t>(triangles);
    }
  }
  constexpr uint64_t kMost = ~uint32_t{0};
  if (triangles >= kMost)
    badInput("the scene's instances have {} triangles together, and the raster compute takes fewer than {}", triangles,
             kMost);
  if (!records_.empty()) list_.upload(uploader, records_);
}

}  // namespace latelight::render
