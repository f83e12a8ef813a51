#include "render/shadow/frame_shadows.h"

#include <algorithm>
#include <bit>
#include <map>
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
  rayColumns_ = plan_.placed.columns;
  if (columns_.empty()) return;
  number(scene.lightCount());
  if (tracesRays()) {
    uploadRays(device, scene);
    return;
  }
  enterMaps();
  // The rounding of the graphics pipeline depends on the position in the atlas, so tiles that depend on earlier frames
  // would change the image.
  if (inCompute_)
    kept.follow(scene);
  else
    kept.reset();
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

bool FrameShadows::repeats(const ShadowPlan& plan, const GpuScene& scene) const {
  const auto same = [](const auto& a, const auto& b) {
    return std::ranges::equal(std::as_bytes(std::span(a)), std::as_bytes(std::span(b)));
  };
  return plan_.sameInAllViews && plan.sameInAllViews && same(plan_.rays, plan.rays) &&
         same(rayLights_, scene.lightsOf(0).lights);
}

// Returns the lights with shadows in a view, in ascending order.
std::vector<uint32_t> FrameShadows::castersOf(size_t view) const {
  std::vector<uint32_t> casters;
  for (const ShadowPlan::Entry& entry : plan_.of[view].lights) casters.push_back(entry.light);
  std::ranges::sort(casters);
  return casters;
}

// With worlds, each view has constants of its own. Its lists depend on no other view then, so its light is added in the
// same order, and has the same bytes, as if it were rendered alone. Without worlds, the views share one list of other
// lights, and rays find no shadows of lights that cast shadows only in other views.
void FrameShadows::uploadRays(vk::Device& device, const GpuScene& scene) {
  ownLists_ = scene.hasWorlds() && !plan_.sameInAllViews;
  std::map<std::pair<uint32_t, std::vector<uint32_t>>, uint64_t> lists;  // by world and casters
  std::vector<shared::Light> others;
  std::vector<shared::RayShadow> rays;
  for (size_t view = 0; view < plan_.of.size(); ++view)
    rayColumns_ = std::max(rayColumns_, static_cast<uint32_t>(plan_.of[view].lights.size()));
  if (!ownLists_) rayColumns_ = static_cast<uint32_t>(columns_.size());
  for (size_t view = 0; view < plan_.of.size(); ++view) {
    const std::vector<uint32_t> casters = ownLists_ ? castersOf(view) : columns_;
    for (uint32_t column = 0; column < rayColumns_; ++column) {
      const uint32_t light = column < casters.size() ? casters[column] : shared::kRayNone;
      const shared::LightShadow shadow =
          column < casters.size() ? table_[view * columns_.size() + columnOf(light)] : shared::LightShadow{};
      rays.push_back(shadow.maps ? plan_.rays[shadow.first] : shared::RayShadow{.light = light});
    }
    if (view > 0 && !ownLists_) continue;
    const uint32_t world = scene.worlds().hasLights() ? plan_.worlds[view] : 0;
    const auto [list, isNew] = lists.try_emplace({world, casters}, others.size() * sizeof(shared::Light));
    otherLights_.push_back(list->second);
    if (!isNew) continue;
    const std::span<const shared::Light> all = scene.lightsOf(world).lights;
    others.resize(others.size() + scene.lightCount());  // the space of the largest world, as of all its lights
    const std::span own = std::span(others).last(scene.lightCount());
    std::ranges::copy(all, own.begin());
    for (const uint32_t light : casters) own[light].intensity = glm::vec3(0);
  }
  if (plan_.sameInAllViews) rayLights_ = scene.lightsOf(0).lights;
  mapsBuffer_ = uploaded(device, "shadow rays", rays);
  lightsBuffer_ = uploaded(device, "lights without shadows", others);
}

bool FrameShadows::omits(uint32_t view, uint32_t light) const {
  return std::ranges::binary_search(ownLists_ ? castersOf(view) : columns_, light);
}

uint32_t FrameShadows::mostRays() const {
  uint32_t most = plan_.placed.mostRays;
  for (const ShadowPlan::OfView& view : plan_.of)
    for (const ShadowPlan::Entry& entry : view.lights) most = std::max(most, entry.maps);
  return most;
}

shared::LightShadow FrameShadows::of(uint32_t view, uint32_t light) const {
  const size_t column = columnOf(light);
  if (column == columns_.size() || columns_[column] != light) return {};
  return table_[view * columns_.size() + column];
}

std::optional<uint32_t> FrameShadows::sun(uint32_t view) const {
  return tracesRays() ? std::nullopt : plan_.of[view].sun;
}

void FrameShadows::describe(shared::FrameConstants& frame) const {
  if (empty()) return;
  if (!tracesRays()) {
    frame.shadowBits = bitsBuffer_.address();
    frame.lightShadows = tableBuffer_.address();
  }
  frame.shadowMaps = plan_.placed.columns > 0 ? plan_.placed.rays : mapsBuffer_.address();
  frame.shadowColumns = columns();
}

}  // namespace latelight::render
