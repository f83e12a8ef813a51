#include "render/shadow/frame_shadows.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/parallel.h"
#include "render/frame.h"
#include "shared/shadow.h"

namespace latelight::render {

namespace {

template <typename T>
vk::Buffer uploaded(vk::Device& device, const char* name, const std::vector<T>& values) {
  return vk::uploadedBuffer(device, name, std::as_bytes(std::span(values)));
}

constexpr size_t kViewsAtOnce = 8;  // a thread's share

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

FrameShadows::FrameShadows(vk::Device& device, const GpuScene& scene, std::span<const shared::View> views,
                           const Settings& settings, KeptShadowMaps& kept)
    : format_(indexOf(settings.shadows)),
      filter_(indexOf(settings.shadowFilter)),
      inCompute_(rastersInCompute(settings)) {
  const ShadowScene planned{scene.lights().lights(), scene.lights().sources(), scene.lights().authored(),
                            scene.bounds()};
  plans_.resize(views.size());
  parallelFor(views.size(), kViewsAtOnce, [&](size_t begin, size_t end) {
    for (size_t view = begin; view < end; ++view) plans_[view] = planShadows(planned, views[view], settings);
  });
  for (const ShadowPlan& plan : plans_)
    for (const ShadowPlan::Entry& entry : plan.lights) columns_.push_back(entry.light);
  std::sort(columns_.begin(), columns_.end());
  columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
  if (columns_.empty()) return;
  number(scene.lights().count());
  // The graphics pipeline rounds by where on its target it draws, so that its maps would depend on the frames before.
  if (inCompute_)
    kept.follow(scene);
  else
    kept.forget();
  place(device, kept);
  upload(device);
}

void FrameShadows::number(uint32_t lights) {
  bits_.resize((lights + 31) / 32);
  for (const uint32_t light : columns_) bits_[light / 32].lights |= 1u << (light % 32);
  for (size_t i = 1; i < bits_.size(); ++i)
    bits_[i].before = bits_[i - 1].before + static_cast<uint32_t>(std::popcount(bits_[i - 1].lights));
  std::vector<std::vector<std::string>> keys(plans_.size());
  parallelFor(plans_.size(), kViewsAtOnce, [&](size_t begin, size_t end) {
    for (size_t view = begin; view < end; ++view)
      for (const ShadowPlan::Entry& entry : plans_[view].lights) keys[view].push_back(keyOf(plans_[view], entry));
  });
  table_.resize(plans_.size() * columns_.size());
  for (size_t view = 0; view < plans_.size(); ++view) {
    const ShadowPlan& plan = plans_[view];
    for (size_t i = 0; i < plan.lights.size(); ++i) {
      const ShadowPlan::Entry& entry = plan.lights[i];
      const auto column = std::lower_bound(columns_.begin(), columns_.end(), entry.light) - columns_.begin();
      table_[view * columns_.size() + static_cast<size_t>(column)] = {
          enter(plan, entry, std::move(keys[view][i])).first, entry.maps, plan.sun == entry.light ? 1u : 0u};
    }
  }
}

std::string FrameShadows::keyOf(const ShadowPlan& plan, const ShadowPlan::Entry& entry) const {
  std::string key;
  append(key, format_);
  append(key, filter_);
  const ShadowView& first = plan.views[entry.first];
  if (first.within) append(key, *first.within);
  for (uint32_t i = entry.first; i < entry.first + entry.maps; ++i) {
    append(key, plan.views[i].drawn);
    append(key, plan.maps[i]);
  }
  return key;
}

// A light's maps in a view: those of an earlier view where they are the same, or new ones.
const FrameShadows::Caster& FrameShadows::enter(const ShadowPlan& plan, const ShadowPlan::Entry& entry,
                                                std::string&& key) {
  const auto [found, anew] = casterOfKey_.try_emplace(std::move(key), static_cast<uint32_t>(casters_.size()));
  if (anew) {
    const ShadowView& first = plan.views[entry.first];
    casters_.push_back({&plan, &entry, static_cast<uint32_t>(records_.size())});
    wanted_.push_back({found->first, entry.maps, first.size, first.within});
    const auto begin = plan.maps.begin() + entry.first;
    records_.insert(records_.end(), begin, begin + entry.maps);
  }
  return casters_[found->second];
}

void FrameShadows::place(vk::Device& device, KeptShadowMaps& kept) {
  vk::ImageDesc kind{.format = shadowImageFormat(format_, inCompute_),
                     .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     .name = "shadow atlas"};
  kind.usage |= inCompute_                ? VK_IMAGE_USAGE_STORAGE_BIT
                : shadowIsPacked(format_) ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
                                          : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  const std::vector<std::shared_ptr<KeptMaps>> placed = kept.place(device, kind, wanted_);
  for (size_t i = 0; i < casters_.size(); ++i) {
    const Caster& caster = casters_[i];
    for (uint32_t m = 0; m < caster.entry->maps; ++m) {
      const AtlasTile& tile = placed[i]->tiles[m];
      shared::ShadowMap& record = records_[caster.first + m];
      record.corner = {tile.x, tile.y};
      record.layer = tile.layer;
      if (!placed[i]->drawn) maps_.push_back({tile, &caster.plan->views[caster.entry->first + m]});
    }
    if (!placed[i]->drawn) drawn_.push_back(placed[i]);
  }
  std::ranges::stable_sort(maps_, {}, [](const Map& map) { return map.tile.layer; });
  atlas_ = kept.atlas();
  keepsAtlas_ = kept.anyDrawn();
  undrawn_ = !maps_.empty();
}

void FrameShadows::settled() {
  for (const std::shared_ptr<KeptMaps>& maps : drawn_) maps->drawn = true;
}

void FrameShadows::upload(vk::Device& device) {
  std::vector<shared::View> views;
  for (const Map& map : maps_) views.push_back(map.view->drawn);
  if (views.empty()) views.emplace_back();
  bitsBuffer_ = uploaded(device, "shadow bits", bits_);
  tableBuffer_ = uploaded(device, "shadows of lights", table_);
  mapsBuffer_ = uploaded(device, "shadow maps", records_);
  viewsBuffer_ = vk::uploadedBuffer(device, "shadow views", std::as_bytes(std::span(views)), kViewUsage);
  constantsBuffer_ = uploaded(device, "shadow constants", std::vector<shared::FrameConstants>(1));
}

shared::LightShadow FrameShadows::of(uint32_t view, uint32_t light) const {
  const auto column = std::lower_bound(columns_.begin(), columns_.end(), light);
  if (column == columns_.end() || *column != light) return {};
  return table_[view * columns_.size() + static_cast<size_t>(column - columns_.begin())];
}

std::optional<uint32_t> FrameShadows::sun(uint32_t view) const {
  return plans_[view].sun;
}

void FrameShadows::describe(shared::FrameConstants& frame) const {
  if (empty()) return;
  frame.shadowBits = bitsBuffer_.address();
  frame.lightShadows = tableBuffer_.address();
  frame.shadowMaps = mapsBuffer_.address();
  frame.shadowColumns = static_cast<uint32_t>(columns_.size());
}

VkDeviceAddress FrameShadows::mapConstants(const shared::FrameConstants& frame) {
  shared::FrameConstants constants = frame;
  constants.views = constants.previousViews = constants.nextViews = viewsBuffer_.address();
  constants.viewCount = static_cast<uint32_t>(maps_.size());
  std::memcpy(constantsBuffer_.mapped(), &constants, sizeof(constants));
  return constantsBuffer_.address();
}

}  // namespace latelight::render
