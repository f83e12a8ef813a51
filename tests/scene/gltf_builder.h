// Builds small glTF files for tests.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/gltf/load.h"
#include "scene/scene.h"

namespace latelight::scene::test {

using nlohmann::json;

enum Component {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};

// A folder that is deleted with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "latelight_gltf_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline void writeBytes(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

inline std::string base64(std::span<const std::byte> bytes) {
  static const char* alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? uint32_t(bytes[i + k]) : 0);
    for (size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? alphabet[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

template <typename T>
std::span<const std::byte> asBytes(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

// A file with one buffer. Add views and accessors, then edit `root` at will.
struct GltfBuilder {
  json root = {{"asset", {{"version", "2.0"}}}};
  std::vector<std::byte> buffer;

  int add(const char* array, json item) {
    root[array].push_back(std::move(item));
    return int(root[array].size()) - 1;
  }
  int view(std::span<const std::byte> bytes, int stride = 0) {
    buffer.resize((buffer.size() + 3) / 4 * 4);
    json item = {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}};
    if (stride) item["byteStride"] = stride;
    buffer.insert(buffer.end(), bytes.begin(), bytes.end());
    return add("bufferViews", item);
  }
  template <typename T>
  int view(const std::vector<T>& values, int stride = 0) {
    return view(asBytes(values), stride);
  }
  int accessor(int bufferView, Component component, const char* type, size_t count) {
    return add("accessors",
               {{"bufferView", bufferView}, {"componentType", component}, {"type", type}, {"count", count}});
  }
  int positions(const std::vector<vec3>& p) { return accessor(view(p), kFloat, "VEC3", p.size()); }
  int vectors(const std::vector<vec2>& p) { return accessor(view(p), kFloat, "VEC2", p.size()); }
  int vectors(const std::vector<vec3>& p) { return accessor(view(p), kFloat, "VEC3", p.size()); }
  int vectors(const std::vector<vec4>& p) { return accessor(view(p), kFloat, "VEC4", p.size()); }

  // Adds a mesh with one primitive, and a node that shows it. Returns the mesh's index.
  int mesh(json primitive) {
    int index = add("meshes", {{"primitives", json::array({std::move(primitive)})}});
    node({{"mesh", index}});
    return index;
  }
  // Adds a root node.
  int node(json item) {
    int index = add("nodes", std::move(item));
    root["scene"] = 0;
    if (!root.contains("scenes")) root["scenes"] = json::array({{{"nodes", json::array()}}});
    root["scenes"][0]["nodes"].push_back(index);
    return index;
  }
  json& primitive() { return root["meshes"][0]["primitives"][0]; }
  void use(const char* extension) { root["extensionsUsed"].push_back(extension); }

  std::vector<std::byte> glb() const {
    json withBuffer = root;
    if (!buffer.empty() && !withBuffer.contains("buffers"))
      withBuffer["buffers"] = json::array({{{"byteLength", buffer.size()}}});
    std::string text = withBuffer.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> out;
    auto word = [&](uint32_t w) {
      for (int i = 0; i < 4; ++i) out.push_back(std::byte(w >> (8 * i)));
    };
    size_t binary = (buffer.size() + 3) / 4 * 4;
    word(0x46546C67), word(2), word(uint32_t(20 + text.size() + (binary ? 8 + binary : 0)));
    word(uint32_t(text.size())), word(0x4E4F534A);
    auto bytes = std::as_bytes(std::span(text));
    out.insert(out.end(), bytes.begin(), bytes.end());
    if (binary) {
      word(uint32_t(binary)), word(0x004E4942);
      out.insert(out.end(), buffer.begin(), buffer.end());
      out.resize(out.size() + binary - buffer.size());
    }
    return out;
  }
  // A single file with a data URI.
  std::string embedded() const {
    json withBuffer = root;
    withBuffer["buffers"] = json::array(
        {{{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer)}}});
    return withBuffer.dump();
  }

  Scene load(const LoadOptions& options = {}) const { return loadBytes(glb(), "scene.glb", options); }

  static Scene loadBytes(std::span<const std::byte> bytes, const char* name, const LoadOptions& options = {}) {
    TemporaryFolder folder;
    writeBytes(folder.path() / name, bytes);
    return loadGltf(folder.path() / name, options);
  }
};

// A unit right triangle in the XY plane: normal +Z, u along +X, v down.
inline GltfBuilder triangleFile() {
  GltfBuilder b;
  int p = b.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  int t = b.vectors(std::vector<vec2>{{0, 1}, {1, 1}, {0, 0}});
  b.mesh({{"attributes", {{"POSITION", p}, {"TEXCOORD_0", t}}}});
  return b;
}

// Returns the message with which loading fails; fails the test if there is no error with this code.
inline std::string errorOf(const GltfBuilder& b, ExitCode code = ExitCode::BadInput, const LoadOptions& options = {}) {
  try {
    b.load(options);
  } catch (const Error& error) {
    EXPECT_EQ(int(error.code()), int(code)) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "loaded without an error";
  return {};
}

inline void expectNear(vec3 a, vec3 b, float tolerance = 1e-6f) {
  EXPECT_LE(glm::length(a - b), tolerance)
      << a.x << ' ' << a.y << ' ' << a.z << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

}  // namespace latelight::scene::test
