#include "base/error.h"
#include "vk/resources.h"

namespace latelight::vk {

namespace {

struct Format {
  VkFormat format;
  const char* name;
  uint32_t bytes, channels;
  FormatKind kind;
};

#define FORMAT(name, bytes, channels, kind) \
  { VK_FORMAT_##name, #name, bytes, channels, FormatKind::kind }

constexpr Format kFormats[] = {
    FORMAT(R8_UNORM, 1, 1, Unorm),
    FORMAT(R8_SNORM, 1, 1, Snorm),
    FORMAT(R8_UINT, 1, 1, Uint),
    FORMAT(R8_SRGB, 1, 1, Srgb),
    FORMAT(R8G8_UNORM, 2, 2, Unorm),
    FORMAT(R8G8_SNORM, 2, 2, Snorm),
    FORMAT(R8G8_UINT, 2, 2, Uint),
    FORMAT(R8G8_SRGB, 2, 2, Srgb),
    FORMAT(R8G8B8A8_UNORM, 4, 4, Unorm),
    FORMAT(R8G8B8A8_SNORM, 4, 4, Snorm),
    FORMAT(R8G8B8A8_UINT, 4, 4, Uint),
    FORMAT(R8G8B8A8_SRGB, 4, 4, Srgb),
    FORMAT(B8G8R8A8_UNORM, 4, 4, Unorm),
    FORMAT(B8G8R8A8_SRGB, 4, 4, Srgb),
    FORMAT(A2B10G10R10_UNORM_PACK32, 4, 4, Unorm),
    FORMAT(A2B10G10R10_UINT_PACK32, 4, 4, Uint),
    FORMAT(B10G11R11_UFLOAT_PACK32, 4, 3, Ufloat),
    FORMAT(E5B9G9R9_UFLOAT_PACK32, 4, 3, Ufloat),
    FORMAT(R16_UNORM, 2, 1, Unorm),
    FORMAT(R16_SNORM, 2, 1, Snorm),
    FORMAT(R16_UINT, 2, 1, Uint),
    FORMAT(R16_SFLOAT, 2, 1, Sfloat),
    FORMAT(R16G16_UNORM, 4, 2, Unorm),
    FORMAT(R16G16_SNORM, 4, 2, Snorm),
    FORMAT(R16G16_UINT, 4, 2, Uint),
    FORMAT(R16G16_SFLOAT, 4, 2, Sfloat),
    FORMAT(R16G16B16A16_UNORM, 8, 4, Unorm),
    FORMAT(R16G16B16A16_SNORM, 8, 4, Snorm),
    FORMAT(R16G16B16A16_UINT, 8, 4, Uint),
    FORMAT(R16G16B16A16_SFLOAT, 8, 4, Sfloat),
    FORMAT(R32_UINT, 4, 1, Uint),
    FORMAT(R32_SFLOAT, 4, 1, Sfloat),
    FORMAT(R32G32_UINT, 8, 2, Uint),
    FORMAT(R32G32_SFLOAT, 8, 2, Sfloat),
    FORMAT(R32G32B32A32_UINT, 16, 4, Uint),
    FORMAT(R32G32B32A32_SFLOAT, 16, 4, Sfloat),
    FORMAT(R64_UINT, 8, 1, Uint),
    FORMAT(D16_UNORM, 2, 1, Depth),
    FORMAT(X8_D24_UNORM_PACK32, 4, 1, Depth),
    FORMAT(D32_SFLOAT, 4, 1, Depth),
    FORMAT(D24_UNORM_S8_UINT, 4, 1, Depth),
    FORMAT(D32_SFLOAT_S8_UINT, 4, 1, Depth),
};

#undef FORMAT

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
uint32_t channelCount(VkFormat format) {
  return find(format).channels;
}
FormatKind formatKind(VkFormat format) {
  return find(format).kind;
}
bool isDepth(VkFormat format) {
  return formatKind(format) == FormatKind::Depth;
}
bool hasStencil(VkFormat format) {
  return format == VK_FORMAT_D24_UNORM_S8_UINT || format == VK_FORMAT_D32_SFLOAT_S8_UINT;
}

}  // namespace latelight::vk
