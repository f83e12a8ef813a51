#include "render/frame/frame_history.h"

namespace latelight::render {

bool FrameHistory::hasSize(uint32_t width, uint32_t height, size_t views) const {
  if (images_[0].empty()) return false;
  const vk::ImageDesc& desc = images_[0].front().desc();
  return desc.width == width && desc.height == height && desc.layers == views;
}

bool FrameHistory::fits(uint32_t width, uint32_t height, size_t views) const {
  return frames_ > 0 && hasSize(width, height, views);
}

void FrameHistory::begin(const FrameContext& f) {
  frames_ = 0;
  if (hasSize(f.width, f.height, f.viewCount())) return;
  constexpr VkImageUsageFlags kUsage =
      VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  for (std::vector<vk::Image>& images : images_) {
    images.clear();
    for (const HistoryTarget& target : targets_)
      images.emplace_back(f.device, vk::ImageDesc{.format = target.format,
                                                  .width = f.width,
                                                  .height = f.height,
                                                  .layers = f.viewCount(),
                                                  .usage = kUsage,
                                                  .name = target.name});
  }
}

FrameHistory::Images FrameHistory::advance(const FrameContext& f) {
  Images some;
  if (frames_ > 0)
    for (const vk::Image& image : images_[newest_])
      some.last.push_back(f.graph.import(image, graph::Use::SampledCompute));
  newest_ = 1 - newest_;
  ++frames_;
  for (const vk::Image& image : images_[newest_]) {
    some.next.push_back(f.graph.import(image, std::nullopt));
    f.graph.exports(some.next.back(), graph::Use::SampledCompute);
  }
  return some;
}

}  // namespace latelight::render
