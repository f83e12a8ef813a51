// A hundred materials with fifty textures: no two textures have the same size, and their storage and sampling differ,
// as in files assembled from many sources.
#include <array>
#include <cmath>

#include "models/parts.h"
#include "output/png.h"

namespace latelight::models {

namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr int kMaterials = 100, kColumns = 10;
// Textures, grouped by kind.
constexpr int kColors = 26, kBumps = 10, kMetals = 10, kGlows = 4;

// Powers of two and other sizes. The numbers of widths and heights are coprime, so every pair is different.
constexpr std::array<uint32_t, 8> kWidths{64, 100, 128, 150, 256, 96, 200, 32};
constexpr std::array<uint32_t, 7> kHeights{64, 80, 128, 256, 120, 144, 48};

// A dot pattern in two colors that depend on `seed`.
vec4 dots(vec2 uv, int seed) {
  const float hue = 0.61803f * static_cast<float>(seed);
  const vec3 light =
      0.6f + 0.4f * vec3(std::cos(6.2832f * hue), std::cos(6.2832f * (hue + 0.33f)), std::cos(6.2832f * (hue + 0.67f)));
  const float cells = static_cast<float>(2 + seed % 5);
  const float dot = glm::length(glm::fract(uv * cells) - 0.5f);
  return vec4(glm::mix(light, 0.3f * light, glm::smoothstep(0.25f, 0.35f, dot)), 1);
}

vec4 bumps(vec2 uv, int seed) {
  const vec2 slope = 0.3f * glm::sin(uv * static_cast<float>(6 + 3 * (seed % 4)) * 6.2832f);
  return vec4(glm::normalize(vec3(slope, 1)) * 0.5f + 0.5f, 1);
}

// Occlusion in R, roughness in G, metalness in B.
vec4 metal(vec2 uv, int seed) {
  const bool band = static_cast<int>(uv.y * static_cast<float>(2 + seed % 3)) % 2 == 0;
  return {1, 0.2f + 0.6f * uv.x, band ? 1 : 0, 1};
}

vec4 glow(vec2 uv, int) {
  return vec4(vec3(0.5f, 0.3f, 0.1f) * glm::step(0.9f, uv.x), 1);
}

// How an image is stored: as JPEG, or as PNG with these channels and this number of bits.
struct Storage {
  uint32_t channels, bits;
};
constexpr std::array<Storage, 5> kStorages{{{4, 8}, {0, 0}, {3, 8}, {3, 16}, {1, 8}}};

Bytes encode(const Picture& picture, Storage storage) {
  if (storage.channels == 0) return encodeJpeg(picture);
  std::vector<uint8_t> samples;
  for (size_t at = 0; at < picture.rgba.size(); at += 4)
    for (size_t channel = 0; channel < storage.channels; ++channel)
      samples.insert(samples.end(), storage.bits / 8, picture.rgba[at + channel]);
  return output::encodePng(picture.width, picture.height, storage.channels, storage.bits,
                           reinterpret_cast<const std::byte*>(samples.data()), output::PngLight::Srgb);
}

// Returns the index of the file's next texture.
int texture(GltfBuilder& file, vec4 (*color)(vec2, int)) {
  const int i = file.root.contains("textures") ? static_cast<int>(file.root["textures"].size()) : 0;
  const auto at = static_cast<size_t>(i);
  const Picture picture =
      paint(kWidths[at % kWidths.size()], kHeights[at % kHeights.size()], [&](vec2 uv) { return color(uv, i); });
  const Storage storage = kStorages[at % kStorages.size()];
  const int image = file.add("images", {{"bufferView", file.view(encode(picture, storage))},
                                        {"mimeType", storage.channels ? "image/png" : "image/jpeg"}});
  return file.add("textures", {{"source", image}, {"sampler", i % 3}});
}

void addSamplers(GltfBuilder& file) {
  enum { kLinear = 9729, kNearestMip = 9985, kTrilinear = 9987 };
  enum { kClamp = 33071, kRepeat = 10497 };
  const auto add = [&](int minify, int wrap) {
    file.add("samplers", {{"magFilter", kLinear}, {"minFilter", minify}, {"wrapS", wrap}, {"wrapT", wrap}});
  };
  add(kTrilinear, kRepeat);
  add(kTrilinear, kClamp);
  add(kNearestMip, kRepeat);
}

}  // namespace

Bytes manyMaterialsModel() {
  GltfBuilder file;
  addSamplers(file);
  const auto textures = [&](int count, vec4 (*color)(vec2, int)) {
    std::vector<int> made;
    for (int i = 0; i < count; ++i) made.push_back(texture(file, color));
    return made;
  };
  const std::vector<int> colors = textures(kColors, dots), normals = textures(kBumps, bumps),
                         metals = textures(kMetals, metal), glows = textures(kGlows, glow);
  const auto of = [](const std::vector<int>& all, int i) {
    return json{{"index", all[static_cast<size_t>(i) % all.size()]}};
  };
  const json ball = primitive(file, sphere(24, 12), 0);
  for (int i = 0; i < kMaterials; ++i) {
    json material{{"name", "material " + std::to_string(i)}};
    json& base = material["pbrMetallicRoughness"] = {{"baseColorTexture", of(colors, i)}, {"metallicFactor", 0.0}};
    if (i % 2) material["normalTexture"] = of(normals, i / 2);
    if (i % 3) {
      base["metallicRoughnessTexture"] = of(metals, i / 3);
      base["metallicFactor"] = 1.0;
    }
    if (i % 4 == 1) material["occlusionTexture"] = of(metals, i / 4);
    if (i % 5 == 2) {
      material["emissiveTexture"] = of(glows, i / 5);
      material["emissiveFactor"] = {1, 1, 1};
    }
    json primitive = ball;
    primitive["material"] = file.add("materials", material);
    const int shown = file.add("meshes", {{"primitives", json::array({primitive})}});
    place(file, "ball " + std::to_string(i), shown,
          {2.2f * static_cast<float>(i % kColumns), 2.2f * (i / kColumns), 0});
  }
  return file.glb();
}

}  // namespace latelight::models
