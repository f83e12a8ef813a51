// Lookups in an environment's prefiltered maps and in the BRDF tables on the host, as in render/glsl/environment.glsl.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "scene/environment/environment.h"
#include "shared/environment.h"
#include "shared/shade.h"

namespace latelight::render::test {

// A map in floats, sampled bilinearly and clamped at the edges.
struct HostMap {
  uint32_t width = 0, height = 0;
  std::vector<shared::vec4> texels;

  explicit HostMap(const scene::RadianceMap& map) : width(map.width), height(map.height) {
    for (size_t y = 0; y < height; ++y)
      for (size_t x = 0; x < width; ++x) texels.emplace_back(map.at(x, y));
  }
  HostMap(uint32_t size, const std::vector<glm::vec2>& values) : width(size), height(size) {
    for (glm::vec2 v : values) texels.emplace_back(v.x, v.y, 0.0f, 0.0f);
  }
  HostMap(uint32_t size, const std::vector<shared::vec3>& values) : width(size), height(size) {
    for (shared::vec3 v : values) texels.emplace_back(v, 0.0f);
  }
  shared::vec4 texel(int x, int y) const {
    x = std::clamp(x, 0, static_cast<int>(width) - 1);
    y = std::clamp(y, 0, static_cast<int>(height) - 1);
    return texels[static_cast<size_t>(y) * width + static_cast<size_t>(x)];
  }
  shared::vec4 bilinear(shared::vec2 uv) const {
    const float px = uv.x * static_cast<float>(width) - 0.5f, py = uv.y * static_cast<float>(height) - 0.5f;
    const int x = static_cast<int>(std::floor(px)), y = static_cast<int>(std::floor(py));
    const float fx = px - std::floor(px), fy = py - std::floor(py);
    return glm::mix(glm::mix(texel(x, y), texel(x + 1, y), fx), glm::mix(texel(x, y + 1), texel(x + 1, y + 1), fx), fy);
  }
};

class HostEnvironment {
 public:
  using vec2 = shared::vec2;
  using vec3 = shared::vec3;

  explicit HostEnvironment(const scene::Environment& environment) : maps_(std::make_shared<Maps>(environment)) {}

  // The same maps, rotated as by `--hdri-rotate`; in radians.
  HostEnvironment turned(float angle) const {
    HostEnvironment other = *this;
    other.cosine_ = std::cos(angle), other.sine_ = std::sin(angle);
    return other;
  }

  vec2 splitSum(float nv, float roughness) const {
    return vec2(maps_->table.bilinear({glm::clamp(nv, 0.0f, 1.0f), roughness}));
  }
  // Returns irradiance / pi.
  vec3 around(vec3 direction) const { return read(maps_->diffuse, octahedral(direction)); }
  // The radiance of the prefiltered mip levels, interpolated between the two nearest.
  vec3 radiance(vec3 direction, float level) const {
    const vec2 o = octahedral(direction);
    const std::vector<HostMap>& levels = maps_->specular;
    const size_t lower = std::min(static_cast<size_t>(level), levels.size() - 2);
    return glm::mix(read(levels[lower], o), read(levels[lower + 1], o), level - static_cast<float>(lower));
  }
  // Mean radiance over a surface's lobe; `diffuse` is the irradiance / pi for the surface's normal.
  vec3 lobe(vec3 normal, float roughness, vec3 toEye, vec3 diffuse) const {
    const float nv = glm::clamp(glm::dot(normal, toEye), 0.0f, 1.0f);
    const shared::vec4 lobe = maps_->lobes.bilinear(shared::lobeTexture(nv, roughness, kLobeTableSize));
    const vec3 core = radiance(shared::lobeDirection(normal, toEye, lobe.x), lobe.y);
    return glm::mix(core, diffuse, lobe.z);
  }
  vec3 light(const shared::Surface& s, vec3 toEye) const {
    const vec3 diffuse = around(s.normal);
    return shared::shadeEnvironment(s, toEye, diffuse, lobe(s.normal, s.roughness, toEye, diffuse),
                                    splitSum(glm::dot(s.normal, toEye), s.roughness));
  }

 private:
  static constexpr uint32_t kTableSize = 32, kLobeTableSize = 16;  // the sizes that the renderer uses

  struct Maps {
    std::vector<HostMap> specular;
    HostMap diffuse, table, lobes;
    explicit Maps(const scene::Environment& environment)
        : specular(environment.specular.begin(), environment.specular.end()),
          diffuse(environment.diffuse),
          table(kTableSize, scene::ggxReflectanceTable(kTableSize)),
          lobes(kLobeTableSize, scene::ggxLobeTable(kLobeTableSize)) {}
  };

  vec2 octahedral(vec3 d) const {
    return shared::octahedralFromDirection(shared::rotateToEnvironment(d, cosine_, sine_));
  }
  static vec3 read(const HostMap& map, vec2 o) {
    return vec3(map.bilinear(shared::octahedralTexture(o, static_cast<float>(map.width))));
  }

  std::shared_ptr<const Maps> maps_;
  float cosine_ = 1.0f, sine_ = 0.0f;
};

}  // namespace latelight::render::test
