#include "render/shadow/frame_shadows.h"

#include <algorithm>
#include <cstring>

#include "render/frame.h"
#include "shared/shadow.h"

namespace latelight::render {

namespace {

template <typename T>
vk::Buffer uploaded(vk::Device& device, const char* name, const std::vector<T>& values) {
  return vk::uploadedBuffer(device, name, std::as_bytes(std::span(values)));
}

bool sameMaps(const ShadowPlan& a, const ShadowPlan::Entry& of, const ShadowPlan& b, const ShadowPlan::Entry& other) {
  if (of.maps != other.maps) return false;
  for (uint32_t i = 0; i < of.maps; ++i) {
    const shared::ShadowMap &x = a.maps[of.first + i], &y = b.maps[other.first + i];
    const shared::View &from = a.views[of.first + i].drawn, &to = b.views[other.first + i].drawn;
    if (std::memcmp(&x, &y, sizeof(x)) != 0 || std::memcmp(&from, &to, sizeof(from)) != 0) return false;
  }
  return true;
}

bool holds(const vk::ImageDesc& atlas, const vk::ImageDesc& needed) {
  return atlas.format == needed.format && atlas.width >= needed.width && atlas.height >= needed.height &&
         atlas.layers >= needed.layers;
}

std::shared_ptr<const vk::Image> atlasFor(vk::Device& device, const vk::ImageDesc& needed, KeptAtlas& kept) {
  if (device.isCpu()) return std::make_shared<const vk::Image>(device, needed);  // allocation is instant there
  constexpr uint32_t kMostLarger = 4;
  const bool fits = kept.image && holds(kept.image->desc(), needed);
  const bool larger = fits && kept.image->desc() != needed;
  kept.larger = larger ? kept.larger + 1 : 0;
  if (!fits || kept.larger > kMostLarger) kept = {std::make_shared<const vk::Image>(device, needed), 0};
  return kept.image;
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
                           const Settings& settings, KeptAtlas& kept)
    : format_(indexOf(settings.shadows)), inCompute_(rastersInCompute(settings)) {
  const ShadowScene planned{scene.lights().lights(), scene.lights().sources(), scene.lights().authored(),
                            scene.bounds()};
  for (const shared::View& view : views) {
    plans_.push_back(planShadows(planned, view, settings));
    for (const ShadowPlan::Entry& entry : plans_.back().lights) columns_.push_back(entry.light);
  }
  std::sort(columns_.begin(), columns_.end());
  columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
  if (columns_.empty()) return;
  number(scene.lights().count());
  upload(device, kept);
}

void FrameShadows::number(uint32_t lights) {
  bits_.resize((lights + 31) / 32);
  for (const uint32_t light : columns_) bits_[light / 32].lights |= 1u << (light % 32);
  for (size_t i = 1; i < bits_.size(); ++i)
    bits_[i].before = bits_[i - 1].before + static_cast<uint32_t>(std::popcount(bits_[i - 1].lights));
  table_.resize(plans_.size() * columns_.size());
  std::vector<std::vector<Drawn>> drawn(columns_.size());
  for (uint32_t view = 0; view < viewCount(); ++view) {
    const size_t before = maps_.size();
    for (const ShadowPlan::Entry& entry : plans_[view].lights) {
      const auto column = std::lower_bound(columns_.begin(), columns_.end(), entry.light) - columns_.begin();
      table_[view * columns_.size() + static_cast<size_t>(column)] =
          enter(view, entry, drawn[static_cast<size_t>(column)]);
    }
    if (maps_.size() > before) ++layers_;
  }
}

// The maps of a light in a view: those of an earlier view where they are bit-identical, or new ones.
shared::LightShadow FrameShadows::enter(uint32_t view, const ShadowPlan::Entry& entry, std::vector<Drawn>& drawn) {
  const ShadowPlan& plan = plans_[view];
  shared::LightShadow shadow{0, entry.maps, plan.sun == entry.light ? 1u : 0u};
  for (const Drawn& other : drawn) {
    if (!sameMaps(plan, entry, plans_[other.view], *other.entry)) continue;
    shadow.first = other.first;
    return shadow;
  }
  shadow.first = static_cast<uint32_t>(maps_.size());
  drawn.push_back({view, &entry, shadow.first});
  for (uint32_t i = entry.first; i < entry.first + entry.maps; ++i) {
    maps_.push_back({layers_, view, &plan.views[i]});
    records_.push_back(plan.maps[i]);
    records_.back().layer = layers_;
  }
  return shadow;
}

void FrameShadows::upload(vk::Device& device, KeptAtlas& kept) {
  vk::ImageDesc atlas{.format = shadowImageFormat(format_, inCompute_),
                      .layers = layers_,
                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                      .name = "shadow atlas"};
  atlas.usage |= inCompute_                ? VK_IMAGE_USAGE_STORAGE_BIT
                 : shadowIsPacked(format_) ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT
                                           : VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  std::vector<shared::View> views;
  for (const ShadowPlan& plan : plans_) {
    atlas.width = std::max(atlas.width, plan.width);
    atlas.height = std::max(atlas.height, plan.height);
  }
  for (const Map& map : maps_) views.push_back(map.view->drawn);
  atlas_ = atlasFor(device, atlas, kept);
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
