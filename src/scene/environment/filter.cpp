// Computes an environment's maps: radiance, the mip chain of prefiltered specular maps, and diffuse irradiance.
#include "scene/environment/filter.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "scene/environment/mirror.h"
#include "scene/environment/picture.h"
#include "scene/environment/tree.h"

namespace latelight::scene {
namespace {

constexpr uint32_t kMaxRadianceWidth = 4096;
// A sun's irradiance has a crease at its horizon, which requires small texels to stay sharp.
constexpr uint32_t kDiffuseSize = 128;

FloatImage limitWidth(FloatImage picture, uint32_t width) {
  if (picture.width <= width) return picture;
  const uint64_t height = (uint64_t{picture.height} * width + picture.width / 2) / picture.width;
  return resizeEquirectangular(picture, width, static_cast<uint32_t>(std::max<uint64_t>(height, 1)));
}

// Finer than a lobe of level 1 can resolve: a leaf of 1024 columns is an eighth of the lobe's half width.
EnvironmentTree makeTree(const FloatImage& picture) {
  const uint32_t width = std::clamp(std::bit_floor(picture.width), 256u, 1024u);
  return EnvironmentTree(resizeEquirectangular(picture, width, width / 2));
}

}  // namespace

Environment filterEnvironment(FloatImage picture) {
  clampRadiance(picture);
  picture = limitWidth(std::move(picture), kMaxRadianceWidth);
  const uint32_t mirrorSize = picture.width <= 512 ? 512 : 1024;

  // Sizes halve per level, from the mirror level down to 32 texels (16 for a coarse image) at roughness 1.
  constexpr size_t kLevels = kSpecularRoughness.size();
  std::vector<FloatImage> specular;
  for (size_t i = 0; i < kLevels; ++i) specular.emplace_back(mirrorSize >> i, mirrorSize >> i);
  FloatImage diffuse(kDiffuseSize, kDiffuseSize);
  resampleMirror(limitWidth(picture, 2 * mirrorSize), specular[0]);
  std::vector<LobeMap> maps;
  for (size_t i = 1; i < kLevels; ++i) maps.push_back({Lobe::Specular, kSpecularRoughness[i], &specular[i]});
  maps.push_back({Lobe::Cosine, 1.0f, &diffuse});
  convolve(makeTree(picture), maps);

  Environment environment;
  environment.radiance = makeRadianceMap(picture, exceedsHalves(picture));
  environment.diffuse = makeRadianceMap(diffuse, exceedsHalves(diffuse));
  const bool isFloat = std::ranges::any_of(specular, exceedsHalves);
  for (const FloatImage& level : specular) environment.specular.push_back(makeRadianceMap(level, isFloat));
  return environment;
}

}  // namespace latelight::scene
