#include "render/visibility/draw_order.h"

#include <algorithm>
#include <tuple>

#include "base/parallel.h"

namespace latelight::render {

namespace {

constexpr size_t kInstancesAtOnce = 16384;  // per task; smaller tasks cost more to start than they save

bool isBlended(const GpuScene& scene, const shared::Instance& instance) {
  return shared::translucent(scene.materials().record(instance.material).flags);
}

bool hasSameTransform(const shared::Instance& a, const shared::Instance& b) {
  return a.mesh == b.mesh && a.material == b.material && a.objectToWorld == b.objectToWorld &&
         a.translationLow == b.translationLow;
}

// Appends an instance, to the last draw if it has the same state.
void append(DrawList& list, const GpuScene& scene, const shared::Instance& record, uint32_t instance) {
  const bool clockwise = (record.flags & shared::kInstanceClockwise) != 0;
  // Layered materials have their own pipelines, which do not draw fans.
  const bool vast = (record.flags & shared::kInstanceVast) != 0 &&
                    !(scene.materials().record(record.material).flags & shared::kMaterialLayered);
  const bool joins = !list.draws.empty() && list.draws.back().mesh == record.mesh &&
                     list.draws.back().material == record.material && list.draws.back().clockwise == clockwise &&
                     list.draws.back().vast == vast;
  if (!joins)
    list.draws.push_back(
        {record.mesh, record.material, clockwise, vast, static_cast<uint32_t>(list.instances.size()), 0});
  ++list.draws.back().count;
  list.instances.push_back(instance);
}

}  // namespace

void DrawOrder::update(const GpuScene& scene) {
  const GpuInstances& all = scene.instances();
  const uint64_t worlds = scene.worlds().hasMaterials() ? scene.worlds().revision() : 0;
  if (instances_ == all.revision() && materials_ == scene.materials().revision() && worlds_ == worlds) return;
  const auto before = [&](uint32_t a, uint32_t b) {
    const shared::Instance &x = all.record(a), &y = all.record(b);
    return std::tie(x.material, x.mesh, a) < std::tie(y.material, y.mesh, b);
  };
  if (order_.size() > all.count()) order_.clear();
  while (order_.size() < all.count()) order_.push_back(static_cast<uint32_t>(order_.size()));
  if (!std::is_sorted(order_.begin(), order_.end(), before)) std::sort(order_.begin(), order_.end(), before);
  anyBlended_ = std::any_of(order_.begin(), order_.end(), [&](uint32_t i) { return isBlended(scene, all.record(i)); });
  for (const uint32_t material : scene.worlds().chosenMaterials())
    anyBlended_ = anyBlended_ || shared::translucent(scene.materials().record(material).flags);
  if (scene.worlds().derivesMaterials()) {
    const auto mayBlend = [&](uint32_t material) {
      return shared::translucent(scene.materials().derivable(material).flags);
    };
    anyBlended_ |= std::ranges::any_of(all.records(), mayBlend, &shared::Instance::material) ||
                   std::ranges::any_of(scene.worlds().chosenMaterials(), mayBlend);
  }
  if (scene.worlds().hasMaterials())
    anyBlended_ |= std::ranges::any_of(scene.worlds().records(),
                                       [&](const shared::Instance& record) { return isBlended(scene, record); });
  covered_.assign(order_.size(), 0);
  parallelFor(order_.size(), kInstancesAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end && i + 1 < order_.size(); ++i)
      covered_[i] = hasSameTransform(all.record(order_[i]), all.record(order_[i + 1])) &&
                    !isBlended(scene, all.record(order_[i])) &&
                    all.bounds(order_[i + 1]).radius >= 0;  // an instance that is not rendered hides nothing
  });
  worlds_ = worlds;  // only now, so that a call after a failure repeats all
  instances_ = all.revision();
  materials_ = scene.materials().revision();
}

DrawList DrawOrder::select(const GpuScene& scene, Kind kind, const std::function<bool(const Sphere&)>& wanted,
                           uint32_t group, uint32_t world) const {
  if (kind == Kind::Blended && !anyBlended_) return {};
  const InstancesOfWorld all = scene.instancesOf(world);
  const bool drawsCovered = scene.hasWorlds();
  const auto look = [&](size_t begin, size_t end, std::vector<uint32_t>& found) {
    for (size_t i = begin; i < end; ++i) {
      const uint32_t instance = order_[i];
      const shared::Instance& record = all.records[instance];
      if (group != 0 && record.flags >> shared::kInstanceGroupShift != group) continue;
      if (covered_[i] && !drawsCovered) continue;
      if (isBlended(scene, record) == (kind == Kind::Blended) && wanted(all.bounds[instance]))
        found.push_back(instance);
    }
  };
  std::vector<std::vector<uint32_t>> parts((order_.size() + kInstancesAtOnce - 1) / kInstancesAtOnce);
  parallelFor(order_.size(), kInstancesAtOnce,
              [&](size_t begin, size_t end) { look(begin, end, parts[begin / kInstancesAtOnce]); });
  DrawList list;
  for (const std::vector<uint32_t>& part : parts)
    for (const uint32_t instance : part) append(list, scene, all.records[instance], instance);
  return list;
}

}  // namespace latelight::render
