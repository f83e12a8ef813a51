// Generates base color, normal and roughness maps from a function of position, in parallel over rows.
#include "scene/builtin/surface_maps.h"

#include <algorithm>
#include <optional>

#include "base/parallel.h"

namespace latelight::scene::builtin {
namespace {

std::byte byteOf(float x) {
  return static_cast<std::byte>(static_cast<int>(std::clamp(x, 0.0f, 1.0f) * 255.0f + 0.5f));
}

void store(Texture& texture, size_t texel, vec3 c) {
  std::byte* out = texture.pixels.get() + 4 * texel;
  for (int i = 0; i < 3; ++i) out[i] = byteOf(c[i]);
  out[3] = std::byte{255};
}

vec2 placeOf(ImageSize size, uint32_t x, size_t y) {
  return {(float(x) + 0.5f) / float(size.width), (float(y) + 0.5f) / float(size.height)};
}

int keep(Scene& scene, std::optional<Texture> texture) {
  if (!texture) return -1;
  buildMips(*texture);
  scene.textures.push_back(std::move(*texture));
  return static_cast<int>(scene.textures.size() - 1);
}

struct Slope {
  float height;
  vec2 tilt;
};

// Converts slopes to a row of the normal map, in tangent space as glTF defines it: x along increasing u, y along
// decreasing v.
void normalRow(Texture& texture, const std::vector<Slope>& slopes, ImageSize size, size_t y) {
  const size_t w = size.width, h = size.height, above = (y + h - 1) % h, below = (y + 1) % h;
  for (size_t x = 0; x < w; ++x) {
    const size_t left = (x + w - 1) % w, right = (x + 1) % w;
    const float du = 0.5f * (slopes[y * w + right].height - slopes[y * w + left].height);
    const float dv = 0.5f * (slopes[below * w + x].height - slopes[above * w + x].height);
    const vec2 tilt = slopes[y * w + x].tilt;
    const vec3 n = glm::normalize(vec3(tilt.x - du, tilt.y + dv, 1));
    store(texture, y * w + x, n * 0.5f + 0.5f);
  }
}

}  // namespace

SurfaceMaps addMaps(Scene& scene, const std::string& name, ImageSize size, const std::function<MapTexel(vec2)>& texel,
                    uint32_t slots) {
  const auto make = [&](uint32_t slot, bool srgb, const char* what) {
    return (slots >> slot & 1u) != 0 ? std::optional(makeTexture(size, srgb, name + what)) : std::nullopt;
  };
  std::optional<Texture> color = make(shared::kTextureBaseColor, true, " base color");
  std::optional<Texture> normal = make(shared::kTextureNormal, false, " normal");
  std::optional<Texture> roughness = make(shared::kTextureMetallicRoughness, false, " roughness");
  if (!color && !normal && !roughness) return {};
  std::vector<Slope> slopes(normal ? size_t{size.width} * size.height : 0);
  parallelFor(size.height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (uint32_t x = 0; x < size.width; ++x) {
        const size_t at = y * size.width + x;
        const MapTexel t = texel(placeOf(size, x, y));
        if (color) store(*color, at, t.color);
        if (roughness) store(*roughness, at, {1, t.roughness, t.metallic});
        if (normal) slopes[at] = {t.height, t.tilt};
      }
    }
  });
  if (normal)
    parallelFor(size.height, 16, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y) normalRow(*normal, slopes, size, y);
    });
  return {keep(scene, std::move(color)), keep(scene, std::move(normal)), keep(scene, std::move(roughness))};
}

int addColorMap(Scene& scene, const std::string& name, ImageSize size, const std::function<vec3(vec2)>& color) {
  Texture texture = makeTexture(size, true, name);
  parallelFor(size.height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (uint32_t x = 0; x < size.width; ++x) store(texture, y * size.width + x, color(placeOf(size, x, y)));
  });
  return keep(scene, std::move(texture));
}

}  // namespace latelight::scene::builtin
