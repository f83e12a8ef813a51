#include "render/shadow/frame_shadows.h"

#include <algorithm>
#include <bit>
#include <set>

#include "base/parallel.h"
#include "render/frame/frame.h"
#include "render/outputs/outputs.h"
#include "shared/shadow.h"

namespace latelight::render {

namespace {

template <typename T>
vk::Buffer uploaded(vk::Device& device, const char* name, const std::vector<T>& values) {
  return vk::uploadedBuffer(device, name, std::as_bytes(std::span(values)));
}

constexpr size_t kMapsAtOnce = 64;            // per task of a worker thread
constexpr uint32_t kFramesUntilFullDraw = 3;  // frames that draw pages of a map before a frame draws the rest of it

template <typename T>
void append(std::string& key, const T& value) {
  key.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace

VkFormat shadowImageFormat(uint32_t format, bool inCompute) {
  if (shadowIsPacked(format)) return VK_FORMAT_R8G8B8A8_UNORM;
  if (inCompute) return format == shared::kShadowD16 ? VK_FORMAT_R16_UNORM : VK_FORMAT_R32_SFLOAT;
  return format == shared::kShadowD16 ? VK_FORMAT_D16_UNORM : VK_FORMAT_D32_SFLOAT;
}

bool shadowIsPacked(uint32_t format) {
  return format == shared::kShadowRgba8 || format == shared::kShadowRgba8Classic;
}

ShadowScene shadowSceneOf(const GpuScene& scene, uint32_t world) {
  const LightSet& set = scene.lightsOf(world);
  return {set.lights, set.sources, set.authored, scene.deviceBounds(world)};
}

FrameShadows::FrameShadows(vk::Device& device, const GpuScene& scene, ShadowPlan plan, const Settings& settings,
                           ShadowMapCache& kept)
    : format_(indexOf(settings.shadows)),
      filter_(indexOf(settings.shadowFilter)),
      inCompute_(rastersInCompute(settings)),
      plan_(std::move(plan)),
      canRequestPages_(inCompute_ && !tracesRays() && !settings.wholeShadowMaps &&
                       !requestsOutput(settings, Origin::LightCounts)) {
  for (const ShadowPlan::OfView& view : plan_.of)
    for (const ShadowPlan::Entry& entry : view.lights) columns_.push_back(entry.light);
  std::sort(columns_.begin(), columns_.end());
  columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
  if (columns_.empty()) return;
  number(scene.lightCount());
  if (tracesRays()) {
    uploadRays(device, scene);
    return;
  }
  enterMaps();
  // The rounding of the graphics pipeline depends on the position in the atlas, so cached maps would depend on earlier
  // frames.
  if (inCompute_)
    kept.follow(scene);
  else
    kept.forget();
  place(device, kept);
  upload(device, scene);
}

void FrameShadows::number(uint32_t lights) {
  bits_.resize((lights + 31) / 32);
  for (const uint32_t light : columns_) bits_[light / 32].lights |= 1u << (light % 32);
  for (size_t i = 1; i < bits_.size(); ++i)
    bits_[i].before = bits_[i - 1].before + static_cast<uint32_t>(std::popcount(bits_[i - 1].lights));
  table_.resize(plan_.of.size() * columns_.size());
  for (size_t view = 0; view < plan_.of.size(); ++view)
    for (const ShadowPlan::Entry& entry : plan_.of[view].lights)
      table_[view * columns_.size() + columnOf(entry.light)] = {entry.first, entry.maps,
                                                                plan_.of[view].sun == entry.light ? 1u : 0u};
}

size_t FrameShadows::columnOf(uint32_t light) const {
  return static_cast<size_t>(std::lower_bound(columns_.begin(), columns_.end(), light) - columns_.begin());
}

std::string FrameShadows::keyOf(uint32_t map) const {
  std::string key;
  append(key, format_);
  append(key, filter_);
  if (plan_.views[map].within) append(key, *plan_.views[map].within);
  append(key, plan_.views[map].drawn);
  append(key, plan_.maps[map]);
  return key;
}

void FrameShadows::enterMaps() {
  std::vector<std::string> keys(plan_.maps.size());
  parallelFor(keys.size(), kMapsAtOnce, [&](size_t begin, size_t end) {
    for (size_t map = begin; map < end; ++map) keys[map] = keyOf(static_cast<uint32_t>(map));
  });
  std::unordered_map<std::string_view, uint32_t> entered;
  for (size_t map = 0; map < keys.size(); ++map) {
    const auto [found, isNew] = entered.try_emplace(keys[map], static_cast<uint32_t>(requested_.size()));
    if (isNew) requested_.push_back({keys[map], &plan_.views[map]});
    requestOfMap_.push_back(found->second);
  }
}

void FrameShadows::place(vk::Device& device, ShadowMapCache& kept) {
  vk::ImageDesc kind{.format = shadowImageFormat(format_, inCompute_),
                     .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     .name = "shadow atlas"};
  kind.usage |= inCompute_                ? VK_IMAGE_USAGE_STORAGE_BIT
                : shadowIsPacked(format_) ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
                                          : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  placed_ = kept.place(device, kind, requested_);
  for (size_t i = 0; i < plan_.maps.size(); ++i) {
    const AtlasTile& tile = placed_[requestOfMap_[i]]->tile;
    plan_.maps[i].corner = {tile.x, tile.y};
    plan_.maps[i].layer = tile.layer;
  }
  atlas_ = kept.atlas();
  pages_ = kept.pages();
  cacheIsDrawn_ = kept.anyDrawn();
  listPagedLights();
  for (size_t i = 0; i < requested_.size(); ++i) list(placed_[i], *requested_[i].view);
  std::ranges::stable_sort(maps_, {}, [](const Map& map) { return map.tile.layer; });
}

// Adds the map to maps_ unless it is completely drawn. If several frames have drawn pages of a map, the map is likely
// to stay. It is then drawn completely, so later frames need not mark its pages.
void FrameShadows::list(const std::shared_ptr<CachedShadowMap>& map, const ShadowView& view) {
  if (map->whole) return;
  const uint32_t drawings = map->drawings + 1;
  maps_.push_back({map->tile, &view, !map->drawn, drawings > kFramesUntilFullDraw});
  map->drawn = false;  // until commit()
  pending_.push_back({map, drawings});
}

void FrameShadows::listPagedLights() {
  std::set<uint32_t> paged;  // indices into columns_
  for (size_t i = 0; i < table_.size(); ++i)
    for (uint32_t map = 0; map < table_[i].maps; ++map)
      if (!placed_[requestOfMap_[table_[i].first + map]]->whole)
        paged.insert(static_cast<uint32_t>(i % columns_.size()));
  for (const uint32_t column : paged) pagedLights_.push_back({columns_[column], column});
}

void FrameShadows::commit(ShadowMapState state) {
  if (state != ShadowMapState::Complete && state != ShadowMapState::Paged) return;
  for (const Pending& pending : pending_) {
    pending.map->drawn = true;
    pending.map->drawings = pending.drawings;
    pending.map->whole = state == ShadowMapState::Complete || pending.drawings > kFramesUntilFullDraw;
  }
}

void FrameShadows::upload(vk::Device& device, const GpuScene& scene) {
  std::vector<shared::View> views;
  for (const Map& map : maps_) views.push_back(map.view->drawn);
  if (views.empty()) views.emplace_back();
  bitsBuffer_ = uploaded(device, "shadow bits", bits_);
  tableBuffer_ = uploaded(device, "shadows of lights", table_);
  mapsBuffer_ = uploaded(device, "shadow maps", plan_.maps);
  viewsBuffer_ = vk::uploadedBuffer(device, "shadow views", std::as_bytes(std::span(views)), kViewUsage);
  // With worlds, each map has constants of its own.
  std::vector<shared::FrameConstants> constants(scene.hasWorlds() ? maps_.size() : 1);
  for (size_t i = 0; i < constants.size(); ++i) {
    scene.describe(constants[i], maps_.empty() ? 0 : maps_[i].view->view.world);
    constants[i].views = constants[i].previousViews = constants[i].nextViews = viewsBuffer_.address();
    constants[i].viewCount = static_cast<uint32_t>(maps_.size());
  }
  constantsBuffer_ = uploaded(device, "shadow constants", constants);
}

void FrameShadows::uploadRays(vk::Device& device, const GpuScene& scene) {
  std::vector<shared::RayShadow> rays;
  for (size_t i = 0; i < table_.size(); ++i) {
    shared::RayShadow none{.light = columns_[i % columns_.size()]};
    rays.push_back(table_[i].maps ? plan_.rays[table_[i].first] : none);
  }
  const uint32_t worlds = scene.worlds().hasLights() ? scene.worlds().count() : 1;
  lightStride_ = worlds > 1 ? scene.lightCount() : 0;
  std::vector<shared::Light> others(size_t{worlds} * scene.lightCount());
  for (uint32_t world = 0; world < worlds; ++world) {
    const std::span own = std::span(others).subspan(world * lightStride_, scene.lightCount());
    std::ranges::copy(scene.lightsOf(world).lights, own.begin());
    for (const uint32_t light : columns_) own[light].intensity = glm::vec3(0);
  }
  mapsBuffer_ = uploaded(device, "shadow rays", rays);
  lightsBuffer_ = uploaded(device, "lights without shadows", others);
}

uint32_t FrameShadows::mostRays() const {
  uint32_t most = 0;
  for (const ShadowPlan::OfView& view : plan_.of) {
    uint32_t rays = 0;
    for (const ShadowPlan::Entry& entry : view.lights) rays += entry.maps;
    most = std::max(most, rays);
  }
  return most;
}

shared::LightShadow FrameShadows::of(uint32_t view, uint32_t light) const {
  const size_t column = columnOf(light);
  if (column == columns_.size() || columns_[column] != light) return {};
  return table_[view * columns_.size() + column];
}

std::optional<uint32_t> FrameShadows::sun(uint32_t view) const {
  return plan_.of[view].sun;
}

void FrameShadows::describe(shared::FrameConstants& frame) const {
  if (empty()) return;
  if (!tracesRays()) {
    frame.shadowBits = bitsBuffer_.address();
    frame.lightShadows = tableBuffer_.address();
  }
  frame.shadowMaps = mapsBuffer_.address();
  frame.shadowColumns = static_cast<uint32_t>(columns_.size());
}

}  // namespace latelight::render
