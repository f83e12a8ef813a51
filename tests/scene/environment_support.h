// Helpers for the tests of environments: images computed from functions of direction, and lookups as in the shaders.
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"
#include "scene/half.h"
#include "shared/environment.h"

namespace latelight::scene {

// The world direction of the center of an equirectangular pixel, from the definition: the center column is glTF's +X, u
// increases towards glTF's +Z (world -Y), the top row is up.
inline glm::vec3 pixelDirection(double x, double y, const FloatImage& image) {
  const double turn = (x / image.width - 0.5) * 2.0 * std::numbers::pi, polar = y / image.height * std::numbers::pi;
  return {std::sin(polar) * std::cos(turn), -std::sin(polar) * std::sin(turn), std::cos(polar)};
}

inline FloatImage makePicture(uint32_t height, const std::function<glm::vec3(const glm::vec3&)>& radiance) {
  FloatImage image(2 * height, height);
  for (uint32_t y = 0; y < image.height; ++y) {
    for (uint32_t x = 0; x < image.width; ++x) {
      const glm::vec3 value = radiance(pixelDirection(x + 0.5, y + 0.5, image));
      float* to = image.at(x, y);
      to[0] = value.x, to[1] = value.y, to[2] = value.z, to[3] = 1.0f;
    }
  }
  return image;
}

inline glm::vec3 texel(const RadianceMap& map, size_t x, size_t y) {
  return map.at(x, y);
}

// Samples like a bilinear sampler that clamps to the edge.
inline glm::vec3 bilinear(const RadianceMap& map, const glm::vec2& uv) {
  const auto size = static_cast<float>(map.width);
  const float x = std::clamp(uv.x * size - 0.5f, 0.0f, size - 1.0f),
              y = std::clamp(uv.y * size - 0.5f, 0.0f, size - 1.0f);
  const auto left = std::min(static_cast<uint32_t>(x), map.width - 2),
             top = std::min(static_cast<uint32_t>(y), map.width - 2);
  const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
  return glm::mix(glm::mix(texel(map, left, top), texel(map, left + 1, top), fx),
                  glm::mix(texel(map, left, top + 1), texel(map, left + 1, top + 1), fx), fy);
}

inline glm::vec3 lookUp(const RadianceMap& map, const glm::vec3& direction) {
  const glm::vec2 o = shared::octahedralFromDirection(direction);
  return bilinear(map, shared::octahedralTexture(o, static_cast<float>(map.width)));
}

// The i-th of `count` directions, uniformly distributed over the sphere (a Fibonacci spiral).
inline glm::vec3 spiral(int i, int count) {
  const double z = 1.0 - (2.0 * i + 1.0) / count, turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

// Sets an environment variable of the process during its lifetime.
class ScopedVariable {
 public:
  ScopedVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~ScopedVariable() {
    if (old_) {
      setenv(name_, old_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> old_;
};

// A temporary folder, deleted at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "latelight-environment-XXXXXX").string();
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

}  // namespace latelight::scene
