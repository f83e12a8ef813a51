// The shadow map cache. follow() compares all instances with those of the previous frame and drops the maps whose
// frustum a changed instance touches, at its old or its new position; a change of materials or of the origin drops all
// maps. place() reuses the remaining maps and allocates tiles for new ones, largest first. If the atlas is full,
// place() drops the maps that the frame does not use, then all maps.
#include "render/shadow/shadow_map_cache.h"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>

#include "render/shadow/pages.h"

namespace latelight::render {

namespace {

uint64_t hashOf(const shared::Instance& record) {
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(&record), sizeof(record)});
}

bool meet(const Sphere& a, const Sphere& b) {
  return glm::length(a.center - b.center) <= a.radius + b.radius;
}

// Returns true if a caster may cast shadows into the map. Vertices are rounded when they are drawn, by more at larger
// distance from the origin.
bool castsInto(const Sphere& caster, const CachedShadowMap& map) {
  constexpr float kRounding = 1e-5f;
  const glm::vec3 at = glm::abs(caster.center);
  const Sphere rounded{caster.center, caster.radius + kRounding * (at.x + at.y + at.z + caster.radius)};
  return (!map.within || meet(*map.within, rounded)) && map.frustum.touches(rounded);
}

// Returns the width and height of a layer of the atlas.
uint32_t sideOf(uint64_t texels, uint32_t largest) {
  constexpr uint64_t kLargestSide = 4096;  // supported by every device
  uint32_t side = largest;
  while (side < kLargestSide && uint64_t{4} * side * side <= texels) side *= 2;
  return side;
}

uint64_t texelsOf(std::span<const ShadowMapCache::Request> requested) {
  uint64_t texels = 0;
  for (const ShadowMapCache::Request& w : requested) texels += uint64_t{w.view->size} * w.view->size;
  return texels;
}

}  // namespace

// --- invalidation ---------------------------------------------------------------------------------------------------

bool ShadowMapCache::Caster::operator==(const Caster& other) const {
  return bounds.center == other.bounds.center && bounds.radius == other.bounds.radius && record == other.record &&
         shape == other.shape;
}

// Returns the old and new bounds of all instances that changed since the last call.
std::vector<Sphere> ShadowMapCache::changedCasters(const GpuScene& scene) {
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

void ShadowMapCache::follow(const GpuScene& scene) try {
  if (const bool had = std::exchange(hadWorlds_, scene.hasWorlds()); had || hadWorlds_) forget();
  if (const uint64_t now = scene.materials().revision(); std::exchange(materials_, now) != now) forget();
  if (std::exchange(origin_, scene.origin()) != scene.origin()) forget();
  const uint64_t instances = scene.instances().revision(), shapes = scene.geometry().revision();
  if (instances_ == instances && shapes_ == shapes) return;
  instances_ = instances;
  shapes_ = shapes;
  const std::vector<Sphere> changed = changedCasters(scene);
  std::erase_if(maps_, [&](const auto& entry) {
    const CachedShadowMap& map = *entry.second;
    const bool stale = std::ranges::any_of(changed, [&](const Sphere& caster) { return castsInto(caster, map); });
    if (stale) tiles_.recycle(map.tile);
    return stale;
  });
} catch (...) {
  // The changes count as followed, so no map may remain. Without an atlas, the next request makes a new one.
  maps_.clear();
  atlas_ = nullptr;
  throw;
}

void ShadowMapCache::forget() {
  for (const auto& [key, map] : maps_) tiles_.recycle(map->tile);
  maps_.clear();
}

void ShadowMapCache::reset() {
  maps_.clear();
  if (atlas_) tiles_ = AtlasTiles(atlas_->desc().width, atlas_->desc().layers);
  isReset_ = true;
}

bool ShadowMapCache::anyDrawn() const {
  return std::ranges::any_of(maps_, [](const auto& entry) { return entry.second->drawn; });
}

std::vector<AtlasTile> ShadowMapCache::tiles() const {
  std::vector<AtlasTile> tiles;
  for (const auto& [key, map] : maps_) tiles.push_back(map->tile);
  return tiles;
}

// --- placement ------------------------------------------------------------------------------------------------------

// Returns true if the atlas fits the request. An atlas that is much too large is replaced only after several frames,
// because creating an atlas costs more time than drawing its maps. After reset(), its layers must have the size of
// those of a new atlas. Their number does not affect the tiles, because those of the first layers are allocated first.
bool ShadowMapCache::holds(const vk::ImageDesc& kind, uint64_t texels, uint32_t largest) {
  if (!atlas_) return false;
  const vk::ImageDesc& has = atlas_->desc();
  const uint64_t capacity = uint64_t{has.width} * has.height * has.layers;
  constexpr uint32_t kFramesUntilFullDraw = 4;  // frames to wait before replacing the atlas
  oversizedFrames_ = capacity > 4 * texels ? oversizedFrames_ + 1 : 0;
  return has.format == kind.format && has.usage == kind.usage && has.width >= largest && capacity >= texels &&
         (oversizedFrames_ <= kFramesUntilFullDraw) && (!isReset_ || has.width == sideOf(texels, largest));
}

void ShadowMapCache::renew(vk::Device& device, vk::ImageDesc kind, uint64_t texels, uint32_t largest) {
  const uint32_t side = sideOf(texels, largest);
  kind.width = kind.height = side;
  kind.layers = static_cast<uint32_t>((texels + uint64_t{side} * side - 1) / (uint64_t{side} * side));
  maps_.clear();
  atlas_ = nullptr;  // until its pages and tiles exist, too
  auto atlas = std::make_shared<const vk::Image>(device, kind);
  pages_ = std::make_shared<const vk::Buffer>(
      device, vk::BufferDesc{.size = sizeof(uint32_t) * pageWords(kind),
                             .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                             .name = "shadow pages"});
  tiles_ = AtlasTiles(side, kind.layers);
  atlas_ = std::move(atlas);
  oversizedFrames_ = 0;
}

void ShadowMapCache::dropUnrequested() {
  std::erase_if(maps_, [&](const auto& entry) {
    const bool unrequested = entry.second->frame != frame_;
    if (unrequested) tiles_.recycle(entry.second->tile);
    return unrequested;
  });
}

std::shared_ptr<CachedShadowMap> ShadowMapCache::add(const Request& requested) {
  const ShadowView& view = *requested.view;
  std::optional<AtlasTile> tile = tiles_.take(view.size);
  if (!tile) {
    dropUnrequested();
    tile = tiles_.take(view.size);
  }
  if (!tile) return nullptr;
  const auto map = std::make_shared<CachedShadowMap>(
      CachedShadowMap{.tile = *tile, .frustum = Frustum(view.view), .within = view.within, .frame = frame_});
  maps_.emplace(requested.key, map);
  return map;
}

// Returns an empty list if the tiles of cached maps leave no space for the new ones.
std::vector<std::shared_ptr<CachedShadowMap>> ShadowMapCache::tryPlace(std::span<const Request> requested) {
  std::vector<std::shared_ptr<CachedShadowMap>> found(requested.size());
  for (size_t i = 0; i < requested.size(); ++i)
    if (const auto kept = maps_.find(requested[i].key); kept != maps_.end()) {
      found[i] = kept->second;
      found[i]->frame = frame_;
    }
  std::vector<uint32_t> order(requested.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order,
                           [&](uint32_t a, uint32_t b) { return requested[a].view->size > requested[b].view->size; });
  for (const uint32_t i : order)
    if (!found[i] && !(found[i] = add(requested[i]))) return {};
  return found;
}

std::vector<std::shared_ptr<CachedShadowMap>> ShadowMapCache::place(vk::Device& device, const vk::ImageDesc& kind,
                                                                    std::span<const Request> requested) {
  ++frame_;
  const uint64_t texels = texelsOf(requested);
  uint32_t largest = 0;
  for (const Request& w : requested) largest = std::max(largest, w.view->size);
  if (!holds(kind, texels, largest)) renew(device, kind, texels, largest);
  isReset_ = false;
  std::vector<std::shared_ptr<CachedShadowMap>> found = tryPlace(requested);
  if (!found.empty()) return found;
  forget();
  return tryPlace(requested);
}

}  // namespace latelight::render
