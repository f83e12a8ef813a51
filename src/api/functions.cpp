// The functions of the public API that require neither a scene nor a renderer.
#include <latelight/latelight.h>

#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/memory.h"
#include "output/png.h"
#include "scene/environment/picture_io.h"
#include "scene/mesh_files/polygon.h"

namespace latelight {

std::vector<std::array<uint32_t, 3>> triangulate(std::span<const std::array<float, 3>> polygon) try {
  std::vector<scene::vec3> corners;
  corners.reserve(polygon.size());
  for (const auto& [x, y, z] : polygon) corners.emplace_back(x, y, z);
  std::vector<std::array<uint32_t, 3>> triangles;
  scene::mesh_files::triangulate(corners, triangles);
  return triangles;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the triangles");
}

EnvironmentData readEnvironment(const std::string& file) try {
  const scene::FloatImage image = scene::readPicture(file);
  EnvironmentData data{.width = image.width, .height = image.height, .radiance = {}};
  data.radiance.resize(size_t{image.width} * image.height);
  for (size_t i = 0; i < data.radiance.size(); ++i)
    for (size_t channel = 0; channel < 3; ++channel) data.radiance[i][channel] = image.pixels[4 * i + channel];
  return data;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the environment");
}

std::vector<std::byte> encodePng(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba) try {
  // Divides, because 4 * width * height may exceed 64 bits.
  if (width == 0 || height == 0 || rgba.size() % 4 != 0 || rgba.size() / 4 != uint64_t{width} * height)
    badUsage("an image of {}x{} pixels has 4 bytes per pixel, but {} bytes are given", width, height, rgba.size());
  return output::encodePng(output::Picture{width, height, rgba});
} catch (const std::bad_alloc&) {
  failWithoutMemory("the image");
}

}  // namespace latelight
