// Conversion between float images and the maps of an Environment as devices sample them.
#include <algorithm>
#include <atomic>
#include <cstring>

#include "base/parallel.h"
#include "scene/environment/environment.h"
#include "scene/half.h"

namespace latelight::scene {

glm::vec4 RadianceMap::at(size_t x, size_t y) const {
  const std::byte* from = texels.data() + texelBytes() * (y * width + x);
  glm::vec4 texel;
  if (isFloat)
    std::memcpy(&texel, from, sizeof(texel));
  else
    floatsFromHalves(reinterpret_cast<const uint16_t*>(from), &texel.x, 4);
  return texel;
}

bool exceedsHalves(const FloatImage& image) {
  constexpr float kFirstUnrepresentable = 65520.0f;  // smaller values round to the largest half, 65504, or below
  std::atomic<bool> exceeds = false;
  const size_t row = size_t{4} * image.width;
  parallelFor(image.height, 32, [&](size_t begin, size_t end) {
    const float* pixels = image.pixels.data();
    if (std::any_of(pixels + begin * row, pixels + end * row,
                    [](float value) { return value >= kFirstUnrepresentable; }))
      exceeds = true;
  });
  return exceeds;
}

RadianceMap makeRadianceMap(const FloatImage& image, bool isFloat) {
  RadianceMap map{image.width, image.height, isFloat, {}};
  map.texels.resize(map.texelBytes() * image.width * image.height);
  const size_t row = size_t{4} * image.width;
  parallelFor(image.height, 32, [&](size_t begin, size_t end) {
    const float* from = image.pixels.data() + begin * row;
    const size_t count = (end - begin) * row;
    if (isFloat) {
      auto* to = reinterpret_cast<float*>(map.texels.data()) + begin * row;
      std::copy_n(from, count, to);
      for (size_t i = 3; i < count; i += 4) to[i] = 1.0f;
    } else {
      auto* to = reinterpret_cast<uint16_t*>(map.texels.data()) + begin * row;
      halvesFromFloats(from, to, count);
      for (size_t i = 3; i < count; i += 4) to[i] = 0x3c00;  // 1
    }
  });
  return map;
}

FloatImage toFloats(const RadianceMap& map) {
  FloatImage image(map.width, map.height);
  if (map.isFloat)
    std::memcpy(image.pixels.data(), map.texels.data(), map.texels.size());
  else
    floatsFromHalves(reinterpret_cast<const uint16_t*>(map.texels.data()), image.pixels.data(), image.pixels.size());
  return image;
}

}  // namespace latelight::scene
