#include "render/shadow/kept_maps.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <string_view>

namespace latelight::render {

namespace {

uint64_t hashOf(const shared::Instance& record) {
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(&record), sizeof(record)});
}

bool meet(const Sphere& a, const Sphere& b) {
  return glm::length(a.centre - b.centre) <= a.radius + b.radius;
}

uint64_t texelsOf(std::span<const KeptShadowMaps::Wanted> wanted) {
  uint64_t texels = 0;
  for (const KeptShadowMaps::Wanted& w : wanted) texels += uint64_t{w.maps} * w.size * w.size;
  return texels;
}

}  // namespace

// --- what they show -------------------------------------------------------------------------------------------------

bool KeptShadowMaps::Caster::operator==(const Caster& other) const {
  return bounds.centre == other.bounds.centre && bounds.radius == other.bounds.radius && record == other.record &&
         shape == other.shape;
}

// Where instances were and are that differ from those of the last time.
std::vector<Sphere> KeptShadowMaps::changedCasters(const GpuScene& scene) {
  const GpuInstances& all = scene.instances();
  std::vector<Sphere> changed;
  std::vector<Caster> now(all.count());
  for (uint32_t i = 0; i < now.size(); ++i) {
    const shared::Instance& record = all.record(i);
    now[i] = {all.bounds(i), hashOf(record), scene.geometry().revision(record.mesh)};
    const bool before = i < casters_.size();
    if (before && casters_[i] == now[i]) continue;
    changed.push_back(now[i].bounds);
    if (before) changed.push_back(casters_[i].bounds);
  }
  casters_ = std::move(now);
  return changed;
}

void KeptShadowMaps::follow(const GpuScene& scene) {
  if (const uint64_t now = scene.materials().revision(); std::exchange(materials_, now) != now) forget();
  const uint64_t instances = scene.instances().revision(), shapes = scene.geometry().revision();
  if (instances_ == instances && shapes_ == shapes) return;
  instances_ = instances;
  shapes_ = shapes;
  const std::vector<Sphere> changed = changedCasters(scene);
  std::erase_if(maps_, [&](const auto& entry) {
    const KeptMaps& maps = *entry.second;
    const bool stale =
        std::ranges::any_of(changed, [&](const Sphere& sphere) { return !maps.within || meet(*maps.within, sphere); });
    if (stale) std::ranges::for_each(maps.tiles, [&](const AtlasTile& tile) { tiles_.giveBack(tile); });
    return stale;
  });
}

void KeptShadowMaps::forget() {
  for (const auto& [key, maps] : maps_)
    for (const AtlasTile& tile : maps->tiles) tiles_.giveBack(tile);
  maps_.clear();
}

bool KeptShadowMaps::anyDrawn() const {
  return std::ranges::any_of(maps_, [](const auto& entry) { return entry.second->drawn; });
}

// --- where they are -------------------------------------------------------------------------------------------------

// One that is much too large is given up, but not at once: creating an atlas takes longer than drawing it.
bool KeptShadowMaps::holds(const vk::ImageDesc& kind, uint64_t texels, uint32_t largest) {
  if (!atlas_) return false;
  const vk::ImageDesc& has = atlas_->desc();
  const uint64_t room = uint64_t{has.width} * has.height * has.layers;
  constexpr uint32_t kPatience = 4;  // frames
  tooLarge_ = room > 4 * texels ? tooLarge_ + 1 : 0;
  return has.format == kind.format && has.usage == kind.usage && has.width >= largest && room >= texels &&
         (tooLarge_ <= kPatience);
}

void KeptShadowMaps::renew(vk::Device& device, vk::ImageDesc kind, uint64_t texels, uint32_t largest) {
  constexpr uint64_t kLargestSide = 4096;  // that every device has
  uint32_t side = largest;
  while (side < kLargestSide && uint64_t{4} * side * side <= texels) side *= 2;
  kind.width = kind.height = side;
  kind.layers = static_cast<uint32_t>((texels + uint64_t{side} * side - 1) / (uint64_t{side} * side));
  maps_.clear();
  atlas_ = std::make_shared<const vk::Image>(device, kind);
  tiles_ = AtlasTiles(side, kind.layers);
  tooLarge_ = 0;
}

void KeptShadowMaps::dropUnasked() {
  std::erase_if(maps_, [&](const auto& entry) {
    const bool unasked = entry.second->frame != frame_;
    if (unasked) std::ranges::for_each(entry.second->tiles, [&](const AtlasTile& tile) { tiles_.giveBack(tile); });
    return unasked;
  });
}

std::shared_ptr<KeptMaps> KeptShadowMaps::add(const Wanted& wanted) {
  const auto maps = std::make_shared<KeptMaps>();
  maps->within = wanted.within;
  maps->frame = frame_;
  while (maps->tiles.size() < wanted.maps) {
    std::optional<AtlasTile> tile = tiles_.take(wanted.size);
    if (!tile) {
      dropUnasked();
      tile = tiles_.take(wanted.size);
    }
    if (!tile) {
      std::ranges::for_each(maps->tiles, [&](const AtlasTile& taken) { tiles_.giveBack(taken); });
      return nullptr;
    }
    maps->tiles.push_back(*tile);
  }
  maps_.emplace(wanted.key, maps);
  return maps;
}

// Empty where the tiles that are kept leave no room for the others.
std::vector<std::shared_ptr<KeptMaps>> KeptShadowMaps::tryPlace(std::span<const Wanted> wanted) {
  std::vector<std::shared_ptr<KeptMaps>> found(wanted.size());
  for (size_t i = 0; i < wanted.size(); ++i)
    if (const auto kept = maps_.find(wanted[i].key); kept != maps_.end()) {
      found[i] = kept->second;
      found[i]->frame = frame_;
    }
  std::vector<uint32_t> order(wanted.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, [&](uint32_t a, uint32_t b) { return wanted[a].size > wanted[b].size; });
  for (const uint32_t i : order)
    if (!found[i] && !(found[i] = add(wanted[i]))) return {};
  return found;
}

std::vector<std::shared_ptr<KeptMaps>> KeptShadowMaps::place(vk::Device& device, const vk::ImageDesc& kind,
                                                             std::span<const Wanted> wanted) {
  ++frame_;
  const uint64_t texels = texelsOf(wanted);
  const uint32_t largest = std::ranges::max(wanted, {}, &Wanted::size).size;
  if (!holds(kind, texels, largest)) renew(device, kind, texels, largest);
  std::vector<std::shared_ptr<KeptMaps>> found = tryPlace(wanted);
  if (!found.empty()) return found;
  forget();
  return tryPlace(wanted);
}

}  // namespace latelight::render
