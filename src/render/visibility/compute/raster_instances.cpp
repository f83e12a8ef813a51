#include "render/visibility/compute/raster_instances.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"

namespace latelight::render {

namespace {

struct Stretch {
  float most;    // upper bound of the scale of lengths
  bool similar;  // angles are preserved
};
Stretch stretchOf(const shared::Instance& instance) {
  const shared::vec3 x = instance.objectToWorld[0], y = instance.objectToWorld[1], z = instance.objectToWorld[2];
  const float xx = glm::dot(x, x), yy = glm::dot(y, y), zz = glm::dot(z, z);
  const float most = std::max({xx, yy, zz}), sum = xx + yy + zz;
  const float skew = std::max({std::abs(glm::dot(x, y)), std::abs(glm::dot(y, z)), std::abs(glm::dot(z, x))});
  constexpr float kRounding = 1e-4f;
  const bool similar = 3 * most - sum <= kRounding * most && skew <= kRounding * most;
  return {(1 + kRounding) * std::sqrt(similar ? most : sum), similar};
}

uint32_t flagsOf(const shared::Instance& instance, const shared::Material& material) {
  uint32_t flags = 0;
  if (material.flags & shared::kMaterialDoubleSided) flags |= shared::kDrawDoubleSided;
  if (instance.flags & shared::kInstanceClockwise) flags |= shared::kDrawClockwise;
  const bool blended = shared::translucent(material.flags);
  if (blended || (material.flags & shared::kMaterialMasked)) flags |= shared::kDrawMasked;
  if (blended) flags |= shared::kDrawBlended;
  if (material.flags & shared::kMaterialLayered) flags |= shared::kDrawLayered;
  if (stretchOf(instance).similar) flags |= shared::kDrawSimilar;
  if (instance.flags & shared::kInstanceVast) flags |= shared::kDrawVast;
  return flags;
}

constexpr uint64_t kMaxParts = (uint64_t{1} << 32) / shared::kRasterGroup;  // triangle ids have 32 bits

}  // namespace

void RasterInstances::update(const GpuScene& scene, const DrawOrder& order, vk::Uploader& uploader) {
  const uint64_t instances = scene.instances().revision(), materials = scene.materials().revision();
  const uint64_t worlds = scene.worlds().revision();
  if (instances_ == instances && materials_ == materials && worlds_ == worlds) return;
  instances_ = ~uint64_t{0};  // until the uploads have succeeded, so that a call after a failure repeats them
  records_.clear();
  partDrawIndices_.clear();
  all_ = {};
  visibleMaterials_ = {};
  anyBlended_ = order.anyBlended();
  mixed_ = scene.worlds().hasMaterials();
  if (mixed_) {
    for (const uint32_t instance : order.all()) add(scene, instance);
    all_.anyOpaque = all_.anyMasked = true;
    solid_ = all_;
  }
  for (const DrawOrder::Kind kind : {DrawOrder::Kind::Solid, DrawOrder::Kind::Blended}) {
    if (mixed_) break;
    for (const uint32_t instance : order.select(scene, kind, [](const Sphere&) { return true; }).instances)
      add(scene, instance);
    if (kind == DrawOrder::Kind::Solid) solid_ = all_;
  }
  if (!records_.empty()) upload(scene, uploader);
  instances_ = instances;
  materials_ = materials;
  worlds_ = worlds;
}

void RasterInstances::upload(const GpuScene& scene, vk::Uploader& uploader) {
  addWorlds(scene);
  if (scene.worlds().onDevice()) {
    templates_.upload(uploader, records_);
    list_.resize(records_.size() * scene.worlds().count());
  } else {
    list_.upload(uploader, records_);
  }
  drawIndexOfPart_.upload(uploader, partDrawIndices_);
  lists_.upload(uploader, std::vector{shared::InstanceList{list_.address(), drawIndexOfPart_.address()}});
  std::vector<uint32_t> firstTriangles(scene.instances().count());
  for (uint32_t i = 0; i < all_.count; ++i) firstTriangles[records_[i].instance] = records_[i].firstTriangle;
  firstTriangles_.upload(uploader, firstTriangles);
}

// Adds the record of an instance in the first world, or in a scene without worlds.
void RasterInstances::add(const GpuScene& scene, uint32_t instance) {
  const InstancesOfWorld all = scene.instancesOf(0);
  const shared::Instance& record = all.records[instance];
  const Sphere& bounds = all.bounds[instance];
  const uint32_t count = scene.geometry().indexCount(record.mesh) / 3;
  const shared::Material& material = scene.materials().record(record.material);
  const uint32_t flags = flagsOf(record, material);
  visibleMaterials_.add(material.flags);
  const auto firstTriangle = static_cast<uint32_t>(all_.parts * shared::kRasterGroup);
  const uint32_t parts = (count + shared::kRasterGroup - 1) / shared::kRasterGroup;
  records_.push_back({bounds.center, bounds.radius, scene.geometry().clusters(record.mesh), stretchOf(record).most,
                      instance, record.mesh, firstTriangle, count, flags});
  all_.parts += parts;
  if (all_.parts >= kMaxParts)
    badInput("the scene's instances have more triangles than the raster compute supports: {} clusters of {}", kMaxParts,
             shared::kRasterGroup);
  partDrawIndices_.insert(partDrawIndices_.end(), parts, all_.count);
  ++all_.count;
  const bool masked = (flags & shared::kDrawMasked) != 0;
  all_.anyMasked |= masked;
  all_.anyOpaque |= !masked;
}

// Adds the kinds of materials that shaders derive: any alpha may make a blended material translucent or opaque.
void RasterInstances::addDerived(const GpuScene& scene) {
  const auto add = [&](uint32_t material) {
    const uint32_t flags = scene.materials().derivable(material).flags;
    visibleMaterials_.add(flags);
    visibleMaterials_.add(flags & ~shared::kMaterialBlended);
  };
  for (const shared::Instance& record : scene.instances().records()) add(record.material);
  for (const uint32_t material : scene.worlds().chosenMaterials()) add(material);
}

// Adds the records of all worlds after the first.
void RasterInstances::addWorlds(const GpuScene& scene) {
  const size_t count = records_.size();
  if (mixed_) {
    for (const shared::Instance& record : scene.worlds().records())
      visibleMaterials_.add(scene.materials().record(record.material).flags);
    for (const uint32_t material : scene.worlds().chosenMaterials())
      visibleMaterials_.add(scene.materials().record(material).flags);
    if (scene.worlds().derivesMaterials()) addDerived(scene);
  }
  if (scene.worlds().count() < 2 || scene.worlds().onDevice()) return;
  records_.resize(count * scene.worlds().count());
  parallelFor(scene.worlds().count() - 1, std::max<size_t>(1, 4096 / count), [&](size_t begin, size_t end) {
    for (size_t world = begin + 1; world < end + 1; ++world) {
      const InstancesOfWorld there = scene.instancesOf(static_cast<uint32_t>(world));
      for (size_t i = 0; i < count; ++i) {
        shared::RasterInstance raster = records_[i];
        const shared::Instance& record = there.records[raster.instance];
        raster.center = there.bounds[raster.instance].center;
        raster.radius = there.bounds[raster.instance].radius;
        raster.mesh = record.mesh;
        raster.clusters = scene.geometry().clusters(record.mesh);
        raster.stretch = stretchOf(record).most;
        raster.flags = flagsOf(record, scene.materials().record(record.material));
        records_[world * count + i] = raster;
      }
    }
  });
}

}  // namespace latelight::render
