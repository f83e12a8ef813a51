// Writes mesh files for tests, and loads them.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "app/folder.h"
#include "base/error.h"
#include "output/png.h"
#include "scene/load/load.h"

namespace latelight::scene::test {

// A folder with one scene file.
class MeshFile {
 public:
  MeshFile(const std::string& name, const std::string& text) : main_(name) { add(name, text); }
  MeshFile& add(const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder_->path() / name).parent_path());
    std::ofstream(folder_->path() / name, std::ios::binary) << text;
    return *this;
  }
  std::string path() const { return folder_->at(main_); }
  Scene load(const LoadOptions& options = {}) const { return scene::load(path(), options); }
  // Returns the message of the error that loading throws; empty if it throws none.
  std::string error(ExitCode code = ExitCode::BadInput, const LoadOptions& options = {}) const {
    try {
      load(options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), testing::HasSubstr(path()));
      return error.what();
    }
    return "";
  }

 private:
  std::shared_ptr<const app::Folder> folder_ = std::make_shared<app::Folder>();  // shared by copies
  std::string main_;
};

template <typename T>
std::string bytesOf(const std::vector<T>& values, bool bigEndian = false) {
  std::string all;
  for (const T value : values) {
    std::string bytes(sizeof(T), '\0');
    std::memcpy(bytes.data(), &value, sizeof(T));
    if (bigEndian) bytes.assign(bytes.rbegin(), bytes.rend());
    all += bytes;
  }
  return all;
}

// An image file with these texels, in rows from the top.
inline std::string png(uint32_t width, uint32_t height, const std::vector<std::array<uint8_t, 4>>& texels) {
  output::Picture picture{width, height, {}};
  for (const auto& texel : texels) picture.rgba.insert(picture.rgba.end(), texel.begin(), texel.end());
  const std::vector<std::byte> bytes = output::encodePng(picture);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The corners of the scene's triangles in its own frame and in meters, in order.
inline std::vector<dvec3> cornersOf(const Scene& scene) {
  std::vector<dvec3> corners;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (const uint32_t index : mesh.indices) {
      const dvec3 world = instance.toWorld * glm::dvec4(mesh.positions[index], 1);
      corners.push_back(scene.yUp ? dvec3(toGltfFromWorld() * glm::dvec4(world, 1)) : world);
    }
  }
  return corners;
}

inline bool near(const dvec3& a, const dvec3& b) {
  return glm::length(a - b) < 1e-6;
}

}  // namespace latelight::scene::test
