#include "models/parts.h"

#include <turbojpeg.h>
#include <webp/encode.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <stdexcept>

#include "output/png.h"

namespace latelight::models {

using glm::vec2;
using glm::vec3;
using glm::vec4;

// --- geometry -------------------------------------------------------------------------------------------------------

Shape card(float width, float height) {
  Shape s;
  for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
    s.positions.emplace_back(corner.x * width / 2, corner.y * height / 2, 0);
    s.normals.emplace_back(0, 0, 1);
    s.uv.push_back(vec2(corner.x, -corner.y) * 0.5f + 0.5f);
  }
  s.indices = {0, 1, 2, 0, 2, 3};
  return s;
}

Shape sphere(int columns, int rows) {
  Shape s;
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column) {
      const vec2 uv(static_cast<float>(column) / static_cast<float>(columns),
                    static_cast<float>(row) / static_cast<float>(rows));
      const float azimuth = glm::two_pi<float>() * uv.x, polar = glm::pi<float>() * uv.y;
      s.normals.emplace_back(-std::sin(polar) * std::sin(azimuth), std::cos(polar),
                             -std::sin(polar) * std::cos(azimuth));
      s.uv.push_back(uv);
    }
  s.positions = s.normals;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto a = static_cast<uint16_t>(row * (columns + 1) + column);
      const auto b = static_cast<uint16_t>(a + columns + 1);
      const auto right = [](uint16_t i) { return static_cast<uint16_t>(i + 1); };
      for (const uint16_t i : {a, b, right(b), a, right(b), right(a)}) s.indices.push_back(i);
    }
  return s;
}

json primitive(GltfBuilder& file, const Shape& shape, int material) {
  json attributes{{"POSITION", file.positions(shape.positions)}, {"NORMAL", file.vectors(shape.normals)}};
  attributes["TEXCOORD_0"] = file.vectors(shape.uv);
  const int indices =
      file.accessor(file.view(shape.indices), scene::test::kUnsignedShort, "SCALAR", shape.indices.size());
  return {{"attributes", attributes}, {"indices", indices}, {"material", material}};
}

int mesh(GltfBuilder& file, const Shape& shape, int material) {
  return file.add("meshes", {{"primitives", json::array({primitive(file, shape, material)})}});
}

json rotation(float degrees, vec3 axis) {
  const glm::quat q = glm::angleAxis(glm::radians(degrees), axis);
  return {q.x, q.y, q.z, q.w};
}
void place(GltfBuilder& file, const std::string& name, int mesh, vec3 at, json more) {
  more["name"] = name;
  more["mesh"] = mesh;
  more["translation"] = {at.x, at.y, at.z};
  file.node(more);
}

int plain(GltfBuilder& file, const char* name, vec3 color, float metallic, float roughness) {
  return file.add("materials", {{"name", name},
                                {"pbrMetallicRoughness",
                                 {{"baseColorFactor", {color.r, color.g, color.b, 1}},
                                  {"metallicFactor", metallic},
                                  {"roughnessFactor", roughness}}}});
}

void perspectiveCamera(GltfBuilder& file, const char* name, vec3 at, float pitch) {
  const int camera = file.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  file.node({{"name", name},
             {"camera", camera},
             {"translation", {at.x, at.y, at.z}},
             {"rotation", rotation(pitch, vec3(1, 0, 0))}});
}

// --- pictures -------------------------------------------------------------------------------------------------------

Picture paint(uint32_t width, uint32_t height, const std::function<vec4(vec2)>& color) {
  Picture picture{width, height, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const vec4 c = color((vec2(x, y) + 0.5f) / vec2(width, height));
      for (int i = 0; i < 4; ++i)
        picture.rgba.push_back(static_cast<uint8_t>(std::lround(glm::clamp(c[i], 0.0f, 1.0f) * 255)));
    }
  return picture;
}

Bytes copyOf(const void* data, size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  return {bytes, bytes + size};
}

Bytes encodeJpeg(const Picture& picture) {
  const tjhandle codec = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(codec, picture.rgba.data(), static_cast<int>(picture.width), 0,
                                 static_cast<int>(picture.height), TJPF_RGBA, &data, &size, TJSAMP_420, 90, 0);
  Bytes bytes = copyOf(data, failed ? 0 : size);
  tjFree(data);
  tjDestroy(codec);
  if (bytes.empty()) throw std::runtime_error("libturbojpeg can't write the test's picture");
  return bytes;
}

namespace {

Bytes encodeWebp(const Picture& picture) {
  uint8_t* data = nullptr;
  const size_t size =
      WebPEncodeLosslessRGBA(picture.rgba.data(), static_cast<int>(picture.width), static_cast<int>(picture.height),
                             static_cast<int>(picture.width) * 4, &data);
  Bytes bytes = copyOf(data, size);
  WebPFree(data);
  if (bytes.empty()) throw std::runtime_error("libwebp can't write the test's picture");
  return bytes;
}

}  // namespace

int addTexture(GltfBuilder& file, const Picture& picture, PictureKind kind, bool alpha) {
  if (alpha && kind == PictureKind::Jpeg) kind = PictureKind::Png;
  const char* type = kind == PictureKind::Jpeg ? "image/jpeg" : kind == PictureKind::Webp ? "image/webp" : "image/png";
  const Bytes bytes = kind == PictureKind::Jpeg   ? encodeJpeg(picture)
                      : kind == PictureKind::Webp ? encodeWebp(picture)
                                                  : output::encodePng(picture);
  const int image = file.add("images", {{"bufferView", file.view(bytes)}, {"mimeType", type}});
  if (kind != PictureKind::Webp) return file.add("textures", {{"source", image}});
  return file.add("textures", {{"extensions", {{"EXT_texture_webp", {{"source", image}}}}}});
}

}  // namespace latelight::models
