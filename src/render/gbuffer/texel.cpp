#include "render/gbuffer/texel.h"

#include <cstdint>
#include <cstring>

#include "base/error.h"
#include "scene/half.h"
#include "shared/color.h"
#include "vk/resources.h"

namespace latelight::render {

namespace {

template <typename T>
T load(const std::byte* from, int index = 0) {
  T value;
  std::memcpy(&value, from + static_cast<size_t>(index) * sizeof(T), sizeof(T));
  return value;
}

float unorm(uint32_t code, uint32_t bits) {
  return static_cast<float>(code) / static_cast<float>((1u << bits) - 1u);
}

}  // namespace

TargetValue decodeTexel(VkFormat format, const std::byte* texel) {
  TargetValue value;
  const uint32_t word = load<uint32_t>(texel);
  switch (format) {
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
      for (int i = 0; i < 4; ++i) {
        value.f[i] = unorm(word >> (8 * i) & 0xff, 8);
        if (format == VK_FORMAT_R8G8B8A8_SRGB && i < 3) value.f[i] = shared::linearFromSrgb(value.f[i]);
      }
      return value;
    case VK_FORMAT_R16G16_UNORM:
      value.f = {unorm(word & 0xffff, 16), unorm(word >> 16, 16), 0, 1};
      return value;
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
      value.f = {unorm(word & 1023, 10), unorm(word >> 10 & 1023, 10), unorm(word >> 20 & 1023, 10),
                 unorm(word >> 30, 2)};
      return value;
    case VK_FORMAT_R16G16_SFLOAT:
      value.f = {scene::floatFromHalf(load<uint16_t>(texel, 0)), scene::floatFromHalf(load<uint16_t>(texel, 1)), 0, 1};
      return value;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
      for (int i = 0; i < 4; ++i) value.f[i] = scene::floatFromHalf(load<uint16_t>(texel, i));
      return value;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
      for (int i = 0; i < 4; ++i) value.f[i] = load<float>(texel, i);
      return value;
    case VK_FORMAT_R32_UINT:
      value.u = {word, 0, 0, 1};
      return value;
    case VK_FORMAT_R32G32_UINT:
      value.u = {word, load<uint32_t>(texel, 1), 0, 1};
      return value;
    case VK_FORMAT_R32G32B32A32_UINT:
      for (int i = 0; i < 4; ++i) value.u[i] = load<uint32_t>(texel, i);
      return value;
    default:
      fail(ExitCode::Internal, "Texels of the format {} cannot be read: add it to render/gbuffer/texel.cpp.",
           vk::formatName(format));
  }
}

}  // namespace latelight::render
