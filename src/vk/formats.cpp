#include "base/error.h"
#include "vk/resources.h"

namespace latelight::vk {

namespace {

struct Format {
  VkFormat format;
  const char* name;
  uint32_t bytes;
  bool depth;
};

#define COLOR(name, bytes) \
  { VK_FORMAT_##name, #name, bytes, false }
#define DEPTH(name, bytes) \
  { VK_FORMAT_##name, #name, bytes, true }

constexpr Format kFormats[] = {
    COLOR(R8_UNORM, 1),
    COLOR(R8_SNORM, 1),
    COLOR(R8_UINT, 1),
    COLOR(R8_SRGB, 1),
    COLOR(R8G8_UNORM, 2),
    COLOR(R8G8_SNORM, 2),
    COLOR(R8G8_UINT, 2),
    COLOR(R8G8_SRGB, 2),
    COLOR(R8G8B8A8_UNORM, 4),
    COLOR(R8G8B8A8_SNORM, 4),
    COLOR(R8G8B8A8_UINT, 4),
    COLOR(R8G8B8A8_SRGB, 4),
    COLOR(B8G8R8A8_UNORM, 4),
    COLOR(B8G8R8A8_SRGB, 4),
    COLOR(A2B10G10R10_UNORM_PACK32, 4),
    COLOR(A2B10G10R10_UINT_PACK32, 4),
    COLOR(B10G11R11_UFLOAT_PACK32, 4),
    COLOR(E5B9G9R9_UFLOAT_PACK32, 4),
    COLOR(R16_UNORM, 2),
    COLOR(R16_SNORM, 2),
    COLOR(R16_UINT, 2),
    COLOR(R16_SFLOAT, 2),
    COLOR(R16G16_UNORM, 4),
    COLOR(R16G16_SNORM, 4),
    COLOR(R16G16_UINT, 4),
    COLOR(R16G16_SFLOAT, 4),
    COLOR(R16G16B16A16_UNORM, 8),
    COLOR(R16G16B16A16_SNORM, 8),
    COLOR(R16G16B16A16_UINT, 8),
    COLOR(R16G16B16A16_SFLOAT, 8),
    COLOR(R32_UINT, 4),
    COLOR(R32_SFLOAT, 4),
    COLOR(R32G32_UINT, 8),
    COLOR(R32G32_SFLOAT, 8),
    COLOR(R32G32B32A32_UINT, 16),
    COLOR(R32G32B32A32_SFLOAT, 16),
    COLOR(R64_UINT, 8),
    DEPTH(D16_UNORM, 2),
    DEPTH(X8_D24_UNORM_PACK32, 4),
    DEPTH(D32_SFLOAT, 4),
    DEPTH(D24_UNORM_S8_UINT, 4),
    DEPTH(D32_SFLOAT_S8_UINT, 4),
};

#undef COLOR
#undef DEPTH

const Format& find(VkFormat format) {
  for (const Format& known : kFormats)
    if (known.format == format) return known;
  fail(ExitCode::Internal, "Image format {} is not in the table of vk/formats.cpp.", static_cast<int>(format));
}

}  // namespace

uint32_t texelBytes(VkFormat format) {
  return find(format).bytes;
}
const char* formatName(VkFormat format) {
  return find(format).name;
}
bool isDepth(VkFormat format) {
  return find(format).depth;
}
bool hasStencil(VkFormat format) {
  return format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

}  // namespace latelight::vk
