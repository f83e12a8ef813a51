#include "models/models.h"

#include <meshoptimizer.h>

#include <array>
#include <cmath>

#include "models/parts.h"
#include "output/exr.h"

namespace latelight::models {

namespace {

using glm::vec2;
using glm::vec3;
using glm::vec4;

const json kLyingFlat = rotation(-90, vec3(1, 0, 0));

// --- images ---------------------------------------------------------------------------------------------------------

Picture paintChecker() {
  return paint(64, 64, [](vec2 uv) {
    const bool light = (static_cast<int>(uv.x * 4) + static_cast<int>(uv.y * 4)) % 2 == 0;
    return light ? vec4(0.9, 0.85, 0.7, 1) : vec4(0.25, 0.4, 0.55, 1);
  });
}

// Rounded bumps, one per field of the checkerboard.
Picture paintBumps() {
  return paint(64, 64, [](vec2 uv) {
    const vec2 within = glm::fract(uv * 4.0f) * 2.0f - 1.0f;
    const vec2 slope = glm::length(within) < 0.9f ? within * 0.6f : vec2(0);
    return vec4(glm::normalize(vec3(slope.x, -slope.y, 1)) * 0.5f + 0.5f, 1);
  });
}

// Occlusion in R, roughness in G, metalness in B: bands of metal whose roughness increases downward.
Picture paintMetalRoughness() {
  return paint(64, 64, [](vec2 uv) {
    const bool metal = static_cast<int>(uv.x * 8) % 2 == 0;
    return vec4(1, 0.15f + 0.7f * uv.y, metal ? 1 : 0, 1);
  });
}

Picture paintHoles() {
  return paint(64, 64, [](vec2 uv) {
    const vec2 within = glm::fract(uv * 3.0f) - 0.5f;
    return vec4(0.8, 0.25, 0.15, glm::length(within) < 0.33f ? 0 : 1);
  });
}

Picture paintGlow() {
  return paint(32, 32, [](vec2 uv) { return vec4(uv.x, 0.6f * uv.y, 1 - uv.x, 1); });
}

// --- textured model -------------------------------------------------------------------------------------------------

int tiledMaterial(GltfBuilder& file, PictureKind kind) {
  const json tiling{{"KHR_texture_transform", {{"scale", {3, 3}}, {"offset", {0.125, 0}}, {"rotation", 0.3}}}};
  const int color = addTexture(file, paintChecker(), kind), bumps = addTexture(file, paintBumps(), kind);
  return file.add("materials", {{"name", "tiles"},
                                {"normalTexture", {{"index", bumps}, {"extensions", tiling}}},
                                {"pbrMetallicRoughness",
                                 {{"baseColorTexture", {{"index", color}, {"extensions", tiling}}},
                                  {"metallicFactor", 0},
                                  {"roughnessFactor", 0.6}}}});
}

int bandedMaterial(GltfBuilder& file, PictureKind kind) {
  const int bands = addTexture(file, paintMetalRoughness(), kind);
  return file.add("materials", {{"name", "bands"},
                                {"occlusionTexture", {{"index", bands}}},
                                {"pbrMetallicRoughness", {{"metallicRoughnessTexture", {{"index", bands}}}}}});
}

int cutMaterial(GltfBuilder& file, PictureKind kind) {
  const int holes = addTexture(file, paintHoles(), kind, true);
  return file.add("materials",
                  {{"name", "holes"},
                   {"alphaMode", "MASK"},
                   {"alphaCutoff", 0.5},
                   {"doubleSided", true},
                   {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", holes}}}, {"metallicFactor", 0}}}});
}

int glowingMaterial(GltfBuilder& file, PictureKind kind) {
  const int glow = addTexture(file, paintGlow(), kind);
  return file.add("materials", {{"name", "glow"},
                                {"emissiveTexture", {{"index", glow}}},
                                {"emissiveFactor", {1, 1, 1}},
                                {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 2}}}}},
                                {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}});
}

int unlitMaterial(GltfBuilder& file, PictureKind kind) {
  const int checker = addTexture(file, paintChecker(), kind);
  return file.add("materials", {{"name", "unlit"},
                                {"extensions", {{"KHR_materials_unlit", json::object()}}},
                                {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", checker}}}}}});
}

// Vertex colors of four bytes, from white at the top to green at the bottom.
int vertexColors(GltfBuilder& file, const Shape& shape) {
  std::vector<uint8_t> colors;
  for (const vec2 uv : shape.uv) {
    const auto fade = static_cast<uint8_t>(std::lround(255 * (1 - uv.y)));
    colors.insert(colors.end(), {fade, 255, fade, 255});
  }
  const int accessor = file.accessor(file.view(colors), scene::test::kUnsignedByte, "VEC4", shape.uv.size());
  file.root["accessors"][accessor]["normalized"] = true;
  return accessor;
}

void orthographicCamera(GltfBuilder& file) {
  const int camera = file.add(
      "cameras",
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 2.25}, {"znear", 0.1}, {"zfar", 20}}}});
  file.node({{"name", "above/orthographic"}, {"camera", camera}, {"translation", {0, 8, 0}}, {"rotation", kLyingFlat}});
}

GltfBuilder buildTextured(PictureKind kind) {
  GltfBuilder file;
  for (const char* name : {"KHR_texture_transform", "KHR_materials_emissive_strength", "KHR_materials_unlit"})
    file.use(name);
  if (kind == PictureKind::Webp) file.use("EXT_texture_webp");
  const Shape ball = sphere(48, 24);
  json banded = primitive(file, ball, bandedMaterial(file, kind));
  banded["attributes"]["COLOR_0"] = vertexColors(file, ball);
  place(file, "floor", mesh(file, card(8, 6), tiledMaterial(file, kind)), {0, 0, 0}, {{"rotation", kLyingFlat}});
  place(file, "ball", file.add("meshes", {{"primitives", json::array({banded})}}), {0, 1, 0});
  place(file, "holes", mesh(file, card(1.6f, 1.6f), cutMaterial(file, kind)), {-2.2f, 0.9f, -0.5f},
        {{"rotation", rotation(30, vec3(0, 1, 0))}});
  place(file, "glow", mesh(file, card(1.2f, 1.2f), glowingMaterial(file, kind)), {2, 0.8f, -0.5f},
        {{"rotation", rotation(-25, vec3(0, 1, 0))}});
  place(file, "unlit", mesh(file, card(0.8f, 0.8f), unlitMaterial(file, kind)), {2.4f, 0.5f, 1});
  perspectiveCamera(file, "front", {0, 2, 6.5f}, -10);
  orthographicCamera(file);
  return file;
}

// --- intricate model ------------------------------------------------------------------------------------------------

// A buffer view that EXT_meshopt_compression unpacks to `values`; the uncompressed buffer is never stored.
template <typename T>
int compressedView(GltfBuilder& file, const std::vector<T>& values, bool indices) {
  Bytes packed(indices ? meshopt_encodeIndexBufferBound(values.size(), 65536)
                       : meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
  auto* target = reinterpret_cast<unsigned char*>(packed.data());
  if constexpr (std::is_same_v<T, uint16_t>)
    packed.resize(meshopt_encodeIndexBuffer(target, packed.size(), values.data(), values.size()));
  else
    packed.resize(meshopt_encodeVertexBuffer(target, packed.size(), values.data(), values.size(), sizeof(T)));
  const int view = file.view(packed);
  const json stored = file.root["bufferViews"][view];
  file.root["bufferViews"][view] = {{"buffer", 1},
                                    {"byteLength", values.size() * sizeof(T)},
                                    {"extensions",
                                     {{"EXT_meshopt_compression",
                                       {{"buffer", 0},
                                        {"byteOffset", stored["byteOffset"]},
                                        {"byteLength", packed.size()},
                                        {"byteStride", sizeof(T)},
                                        {"count", values.size()},
                                        {"mode", indices ? "TRIANGLES" : "ATTRIBUTES"}}}}}};
  return view;
}

int compressedMesh(GltfBuilder& file, int material) {
  file.use("EXT_meshopt_compression");
  const Shape ball = sphere(24, 12);
  std::vector<vec4> positions;  // a stride of 16, because the codec requires multiples of four
  for (const vec3 p : ball.positions) positions.emplace_back(p, 0);
  const int view = compressedView(file, positions, false);
  file.root["bufferViews"][view]["byteStride"] = sizeof(vec4);
  const int position = file.accessor(view, scene::test::kFloat, "VEC3", positions.size());
  const int indices = file.accessor(compressedView(file, ball.indices, true), scene::test::kUnsignedShort, "SCALAR",
                                    ball.indices.size());
  json p{{"attributes", {{"POSITION", position}}}, {"indices", indices}, {"material", material}};
  return file.add("meshes", {{"primitives", json::array({p})}});
}

// A square with 16-bit positions (KHR_mesh_quantization) as a strip, and a fan without indices.
int quantisedMesh(GltfBuilder& file, int material) {
  file.use("KHR_mesh_quantization");
  const std::vector<int16_t> corners{-32767, -32767, 0, 0, 32767, -32767, 0, 0,
                                     -32767, 32767,  0, 0, 32767, 32767,  0, 0};
  const int strip = file.accessor(file.view(scene::test::asBytes(corners), 8), scene::test::kShort, "VEC3", 4);
  file.root["accessors"][strip]["normalized"] = true;
  const int fan = file.positions({{0, 0, 0.5f}, {0.5f, 0, 0.5f}, {0.4f, 0.4f, 0.5f}, {0, 0.5f, 0.5f}});
  return file.add("meshes", {{"primitives",
                              json::array({{{"attributes", {{"POSITION", strip}}}, {"mode", 5}, {"material", material}},
                                           {{"attributes", {{"POSITION", fan}}}, {"mode", 6}}})}});
}

// A card with one corner moved by a sparse accessor. The variant selects one of two materials.
int sparseMesh(GltfBuilder& file, int material, int other) {
  file.use("KHR_materials_variants");
  file.root["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "red"}}, {{"name", "blue"}}};
  json p = primitive(file, card(1, 1), material);
  const int corner = file.view(std::vector<uint8_t>{2}), moved = file.view(std::vector<vec3>{{0.8f, 0.9f, 0}});
  file.root["accessors"][p["attributes"]["POSITION"].get<int>()]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", corner}, {"componentType", scene::test::kUnsignedByte}}},
      {"values", {{"bufferView", moved}}}};
  p["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", material}, {"variants", {0}}},
                                                           {{"material", other}, {"variants", {1}}}};
  return file.add("meshes", {{"primitives", json::array({p})}});
}

json instancing(GltfBuilder& file) {
  file.use("EXT_mesh_gpu_instancing");
  const int at = file.positions({{-2, 0, 0}, {0, 0.5f, 0}, {2, 0, 0}});
  // Rotated by 0, 40 and -40 degrees about Y.
  const int turned =
      file.vectors(std::vector<vec4>{{0, 0, 0, 1}, {0, 0.3420201f, 0, 0.9396926f}, {0, -0.3420201f, 0, 0.9396926f}});
  return {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", at}, {"ROTATION", turned}}}}}};
}

// --- panoramas ------------------------------------------------------------------------------------------------------

// A blue sky over brown ground, and a sun of 40 by 10 degrees in the center column, 35 degrees up.
vec3 sky(vec2 uv) {
  const float azimuth = (uv.x - 0.5f) * 360, elevation = (0.5f - uv.y) * 180;
  const vec3 base =
      elevation > 0 ? glm::mix(vec3(0.8, 0.9, 1), vec3(0.15, 0.35, 0.9), elevation / 90) : vec3(0.25, 0.18, 0.12);
  return glm::length(vec2(azimuth, elevation - 35)) < 5 ? vec3(40, 36, 28) : base;
}

std::vector<vec3> paintSky(uint32_t width, uint32_t height) {
  std::vector<vec3> pixels;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) pixels.push_back(sky((vec2(x, y) + 0.5f) / vec2(width, height)));
  return pixels;
}

std::array<uint8_t, 4> rgbe(vec3 color) {
  const float largest = std::max({color.r, color.g, color.b});
  int exponent = 0;
  const float scale = std::frexp(largest, &exponent) * 256 / largest;
  return {static_cast<uint8_t>(color.r * scale), static_cast<uint8_t>(color.g * scale),
          static_cast<uint8_t>(color.b * scale), static_cast<uint8_t>(exponent + 128)};
}

}  // namespace

Bytes punctualModel() {
  GltfBuilder file;
  file.use("KHR_lights_punctual");
  file.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "directional"}, {"intensity", 1.0}, {"color", {1, 0.9, 0.8}}},
      {{"type", "point"}, {"intensity", 12}, {"range", 4}, {"color", {0.3, 0.6, 1}}},
      {{"type", "spot"},
       {"intensity", 60},
       {"color", {1, 0.5, 0.2}},
       {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.4}}}}};
  const Shape ball = sphere(48, 24);
  place(file, "floor", mesh(file, card(10, 8), plain(file, "stone", vec3(0.6f), 0, 0.7f)), {0, 0, 0},
        {{"rotation", kLyingFlat}});
  place(file, "wall", mesh(file, card(10, 5), plain(file, "plaster", {0.7f, 0.65f, 0.6f}, 0, 0.9f)), {0, 2.5f, -3});
  place(file, "dielectric", mesh(file, ball, plain(file, "red", {0.8f, 0.1f, 0.1f}, 0, 0.3f)), {-2.2f, 1, 0});
  place(file, "metal", mesh(file, ball, plain(file, "gold", {1, 0.77f, 0.34f}, 1, 0.35f)), {0, 1, 0});
  place(file, "rough", mesh(file, ball, plain(file, "chalk", vec3(0.8f), 0, 1)), {2.2f, 1, 0});
  const auto light = [&](const char* name, int index, vec3 at, const json& turned) {
    file.node({{"name", name},
               {"translation", {at.x, at.y, at.z}},
               {"rotation", turned},
               {"extensions", {{"KHR_lights_punctual", {{"light", index}}}}}});
  };
  light("sun", 0, {0, 5, 0}, rotation(-50, glm::normalize(vec3(1, 0.4f, 0))));
  light("lamp", 1, {-1.1f, 2.2f, 1.2f}, rotation(0, vec3(0, 1, 0)));
  light("spot", 2, {3, 4, 2}, rotation(-60, vec3(1, 0, 0)));
  perspectiveCamera(file, "front", {0, 2, 7}, -8);
  return file.glb();
}

Bytes texturedModel() {
  return texturedModel(PictureKind::Png);
}

Bytes texturedModel(PictureKind kind) {
  return buildTextured(kind).glb();
}

std::string embeddedModel() {
  return buildTextured(PictureKind::Png).embedded();
}

Bytes blendedModel() {
  GltfBuilder file;
  const Shape ball = sphere(32, 16);
  const auto glass = [&](const char* name, vec3 color, float alpha) {
    const int material = plain(file, name, color, 0, 0.2f);
    json& made = file.root["materials"][material];
    made["alphaMode"] = "BLEND";
    made["doubleSided"] = true;
    made["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha;
    return material;
  };
  place(file, "floor", mesh(file, card(6, 5), tiledMaterial(file, PictureKind::Png)), {0, 0, 0},
        {{"rotation", kLyingFlat}});
  place(file, "chalk", mesh(file, ball, plain(file, "chalk", vec3(0.8f), 0, 0.9f)), {-1.2f, 1, -0.8f});
  place(file, "gold", mesh(file, ball, plain(file, "gold", {1, 0.77f, 0.34f}, 1, 0.35f)), {1.2f, 1, -0.8f});
  place(file, "bubble", mesh(file, ball, glass("bubble", {0.6f, 0.8f, 1}, 0.25f)), {0, 0.7f, 0.7f},
        {{"scale", {0.6, 0.6, 0.6}}});
  place(file, "red pane", mesh(file, card(1.6f, 2), glass("red glass", {0.9f, 0.1f, 0.1f}, 0.4f)), {-1, 1, 1.2f},
        {{"rotation", rotation(15, vec3(0, 1, 0))}});
  place(file, "green pane", mesh(file, card(1.6f, 2), glass("green glass", {0.1f, 0.8f, 0.2f}, 0.6f)), {0.6f, 1, 1.6f});
  place(file, "holes", mesh(file, card(1.2f, 1.2f), cutMaterial(file, PictureKind::Png)), {1.8f, 0.8f, 1});
  perspectiveCamera(file, "front", {0, 1.6f, 6}, -6);
  return file.glb();
}

Bytes intricateModel() {
  GltfBuilder file;
  const int red = plain(file, "red", {0.8f, 0.15f, 0.1f}, 0, 0.5f),
            blue = plain(file, "blue", {0.1f, 0.2f, 0.8f}, 1, 0.4f);
  place(file, "compressed", compressedMesh(file, red), {0, 1, -1}, {{"scale", {-1, 1, 1}}});
  place(file, "quantised", quantisedMesh(file, blue), {-2, 1, 0});
  place(file, "sparse", sparseMesh(file, red, blue), {0, 0, 1}, {{"extensions", instancing(file)}});
  perspectiveCamera(file, "front", {0, 1, 6}, -5);
  // The second buffer would contain the unpacked views of meshopt; it has no bytes.
  file.buffer.resize((file.buffer.size() + 3) / 4 * 4);
  file.root["buffers"] = {
      {{"byteLength", file.buffer.size()}},
      {{"byteLength", 1 << 16}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  return file.glb();
}

std::map<std::string, Bytes> allModels() {
  return {{"punctual.glb", punctualModel()},
          {"textured.glb", texturedModel()},
          {"intricate.glb", intricateModel()},
          {"skinned.glb", skinnedModel()},
          {"static_skin.glb", skinnedModel(glm::dvec3(0), false)},
          {"morphed.glb", morphedModel()},
          {"blended.glb", blendedModel()},
          {"many_materials.glb", manyMaterialsModel()},
          {"sky.hdr", radiancePanorama(1024, 512)},
          {"sky.exr", exrPanorama(1024, 512)}};
}

Bytes radiancePanorama(uint32_t width, uint32_t height) {
  std::string text =
      "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) + " +X " + std::to_string(width) + "\n";
  const std::vector<vec3> pixels = paintSky(width, height);
  for (uint32_t y = 0; y < height; ++y) {
    text += {2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)};
    for (size_t channel = 0; channel < 4; ++channel)
      for (uint32_t x = 0; x < width;) {
        const auto value = [&](uint32_t at) { return rgbe(pixels[y * width + at])[channel]; };
        uint32_t run = 1;
        while (x + run < width && run < 127 && value(x + run) == value(x)) ++run;
        text += {static_cast<char>(run == 1 ? 1 : 128 + run), static_cast<char>(value(x))};
        x += run;
      }
  }
  return copyOf(text.data(), text.size());
}

Bytes exrPanorama(uint32_t width, uint32_t height) {
  output::AovImage image = output::makeAovImage(output::Aov::Color, width, height);
  const std::vector<vec3> pixels = paintSky(width, height);
  for (size_t i = 0; i < pixels.size(); ++i)
    for (int c = 0; c < 4; ++c) image.values[4 * i + static_cast<size_t>(c)] = c < 3 ? pixels[i][c] : 1;
  const output::AovImage* images[] = {&image};
  return output::encodeExr(images, {});
}

}  // namespace latelight::models
