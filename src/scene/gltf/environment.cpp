// Reads EXT_lights_image_based: resamples the specular cube map to an equirectangular image, filters it like any other
// environment, and evaluates the irradiance's spherical harmonics for the diffuse map.
#include "scene/gltf/environment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"
#include "scene/environment/environment.h"
#include "scene/environment/octahedral_map.h"
#include "scene/environment/picture.h"
#include "scene/textures/texture.h"
#include "shared/color.h"

namespace latelight::scene::gltf {
namespace {

constexpr uint32_t kMinHeight = 64, kMaxHeight = 1024;  // height of the resampled image

vec3 gltfFromWorld(const vec3& d) {
  return {d.x, d.z, -d.y};
}

// Returns the rotation from the file's frame to the light's own frame; the inverse of the light's rotation.
glm::mat3 readTurn(const file::ImageBasedLight& light) {
  const vec4& r = light.rotation;
  const glm::quat q(r.w, r.x, r.y, r.z);
  const float length = glm::length(q);
  return length > 0 && std::isfinite(length) ? glm::transpose(glm::mat3_cast(q / length)) : glm::mat3(1);
}

// --- the cube map ----------------------------------------------------------------------------------------------------

class Cube {
 public:
  Cube(const Document& document, const std::array<int, 6>& faces) {
    for (size_t i = 0; i < 6; ++i) {
      const ImageSource& source = document.images[size_t(faces[i])];
      if (!source.problem.empty()) badInput("{}", source.problem);
      const ImageSize size = imageSize(source.encoded, source.name);
      if (size.width != size.height || (i > 0 && size.width != faces_[0].width))
        badInput("{} is {}x{} pixels, but the faces of a cube must be squares of the same size", source.name,
                 size.width, size.height);
      document.budget.charge(mipChainBytes(size), source.name);
      faces_[i] = decodeTexture(source.encoded, true, source.name);
    }
  }
  uint32_t side() const { return faces_[0].width; }

  // Samples bilinearly within a face. The faces are oriented as in OpenGL 4.6, section 8.13.
  vec3 radiance(const vec3& d) const {
    const vec3 a = glm::abs(d);
    const size_t axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    const bool back = d[int(axis)] < 0;
    const vec2 st = axis == 0   ? vec2(back ? d.z : -d.z, -d.y)
                    : axis == 1 ? vec2(d.x, back ? -d.z : d.z)
                                : vec2(back ? -d.x : d.x, -d.y);
    return sample(faces_[2 * axis + back], (st / a[int(axis)] + 1.0f) * 0.5f * float(side()) - 0.5f);
  }

 private:
  static vec3 sample(const Texture& face, const vec2& at) {
    const vec2 low = glm::floor(at), part = at - low;
    const int x = int(low.x), y = int(low.y);
    return glm::mix(glm::mix(texel(face, x, y), texel(face, x + 1, y), part.x),
                    glm::mix(texel(face, x, y + 1), texel(face, x + 1, y + 1), part.x), part.y);
  }

  // Decodes RGBD: values above 1 are stored divided by alpha.
  static vec3 texel(const Texture& face, int x, int y) {
    const int last = int(face.width) - 1;
    const std::byte* p =
        &face.pixels[4 * (size_t(std::clamp(y, 0, last)) * face.width + size_t(std::clamp(x, 0, last)))];
    const vec3 color = vec3(float(p[0]), float(p[1]), float(p[2])) / 255.0f;
    return shared::linearFromSrgb(color) * 255.0f / std::max(float(p[3]), 1.0f);
  }

  std::array<Texture, 6> faces_;
};

FloatImage pictureOf(const Cube& cube, const glm::mat3& turn, float intensity) {
  const uint32_t height = std::clamp(2 * cube.side(), kMinHeight, kMaxHeight);
  FloatImage picture(2 * height, height);
  const double step = std::numbers::pi / height;
  parallelFor(height, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const double polar = (double(y) + 0.5) * step;
      for (size_t x = 0; x < picture.width; ++x) {
        const double azimuth = (double(x) + 0.5) * step - std::numbers::pi;
        const vec3 d(std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth));
        const vec4 radiance(cube.radiance(turn * d) * intensity, 1);
        std::copy_n(&radiance.x, 4, picture.at(x, y));
      }
    }
  });
  return picture;
}

// --- irradiance ------------------------------------------------------------------------------------------------------

using Harmonics = std::array<vec3, 9>;

// Evaluates the real spherical harmonics of bands 0 to 2 (R. Ramamoorthi and P. Hanrahan, "An Efficient Representation
// for Irradiance Environment Maps", SIGGRAPH 2001, equation 3).
vec3 irradiance(const Harmonics& c, const vec3& n) {
  const vec3 linear = c[1] * n.y + c[2] * n.z + c[3] * n.x;
  const vec3 mixed = c[4] * n.x * n.y + c[5] * n.y * n.z + c[7] * n.x * n.z;
  return 0.282095f * c[0] + 0.488603f * linear + 1.092548f * mixed + 0.315392f * c[6] * (3 * n.z * n.z - 1) +
         0.546274f * c[8] * (n.x * n.x - n.y * n.y);
}

RadianceMap makeDiffuse(uint32_t size, const Harmonics& harmonics, const glm::mat3& turn, float intensity) {
  FloatImage map(size, size);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const vec3 n = turn * gltfFromWorld(mapDirection(float(x), float(y), size));
      const vec3 value = irradiance(harmonics, n) * (intensity / std::numbers::pi_v<float>);
      setTexel(map, x, y, vec4(value, 1));
    }
  closeSeams(map);
  clampRadiance(map);
  return makeRadianceMap(map, exceedsHalves(map));
}

const file::ImageBasedLight* lightOf(const file::Model& model) {
  if (model.scenes.empty()) return nullptr;
  const int light = model.scenes[size_t(std::max(model.scene, 0))].imageBasedLight;
  return light < 0 ? nullptr : &model.imageBasedLights[size_t(light)];
}

}  // namespace

void readEnvironment(const Document& document, Scene& scene) {
  const file::ImageBasedLight* light = lightOf(document.model);
  if (!light) return;
  const glm::mat3 turn = readTurn(*light);
  const auto intensity = float(light->intensity);
  const Cube cube(document, light->specularImages);
  if (cube.side() != uint32_t(light->specularImageSize))
    warn("the image-based light's specularImageSize is {}, but its faces have {}x{} pixels: it is ignored",
         light->specularImageSize, cube.side(), cube.side());
  Environment environment = makeEnvironment(pictureOf(cube, turn, intensity));
  environment.diffuse = makeDiffuse(environment.diffuse.width, light->irradianceCoefficients, turn, intensity);
  environment.name = "scene";
  scene.environment = std::make_shared<Environment>(std::move(environment));
}

}  // namespace latelight::scene::gltf
