#include "render/gbuffer/layout.h"

#include "render/base/registry.h"
#include "vk/resources.h"

namespace latelight::render {

#define LAYOUT(name) Layout makeLayout_##name();
#include "layouts.inc"
#undef LAYOUT

VkFormat Layout::format(size_t target, uint32_t normalEncoding) const {
  VkFormat format = targets[target].format;
  if (format != VK_FORMAT_UNDEFINED) return format;
  return shared::normalChannels(normalEncoding) == 2 ? VK_FORMAT_R16G16_UNORM : VK_FORMAT_A2B10G10R10_UNORM_PACK32;
}

LayoutBytes Layout::bytesPerPixel(uint32_t normalEncoding) const {
  LayoutBytes bytes{0, vk::texelBytes(kDepthFormat), vk::texelBytes(kLightFormat)};
  for (size_t i = 0; i < targets.size(); ++i) bytes.targets += vk::texelBytes(format(i, normalEncoding));
  return bytes;
}

LayoutBytes Layout::originalBytesPerPixel(uint32_t normalEncoding) const {
  return {bytesPerPixel(normalEncoding).targets, vk::texelBytes(originalDepth), vk::texelBytes(originalLight)};
}

std::span<const Layout> layouts() {
  static const std::vector<Layout> all = {
#define LAYOUT(name) makeLayout_##name(),
#include "layouts.inc"
#undef LAYOUT
  };
  return all;
}

const Layout& findLayout(std::string_view name) {
  return findByName(layouts(), name, "G-buffer layout");
}

std::span<const NormalEncoding> normalEncodings() {
  static const std::vector<NormalEncoding> all = {
#define NORMAL(name, index)                                                                                         \
  NormalEncoding{registryName(#name), index, shared::kNormalChannels_##name, shared::kNormalHemisphere_##name != 0, \
                 NORMAL_DESCRIPTION_##name},
      LATELIGHT_NORMALS(NORMAL)
#undef NORMAL
  };
  return all;
}

const NormalEncoding& findNormalEncoding(std::string_view name) {
  return findByName(normalEncodings(), name, "normal encoding");
}

}  // namespace latelight::render
