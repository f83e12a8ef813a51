#include "render/gpu_scene/gpu_environment.h"

#include <algorithm>
#include <array>
#include <bit>

#include "shared/environment.h"

namespace latelight::render {

namespace {

constexpr uint32_t kTableSize = 32, kLobeTableSize = 16;

vk::Image upload(vk::Device& device, vk::Uploader& uploader, vk::ImageDesc desc, std::span<const std::byte> texels) {
  desc.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  vk::Image image(device, desc);
  uploader.upload(image, texels);
  return image;
}

using Texels = decltype(scene::RadianceMap::texels);

VkFormat formatOf(bool isFloat) {
  return isFloat ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
}

size_t blackBytes(uint32_t width, uint32_t height, bool isFloat) {
  return scene::RadianceMap{.isFloat = isFloat, .texels = {}}.texelBytes() * width * height;
}

using Environments = std::span<const scene::Environment* const>;

void append(Texels& texels, const scene::RadianceMap& map) {
  texels.insert(texels.end(), map.texels.begin(), map.texels.end());
}

// Returns true if one of these maps has halves and another one floats.
template <typename MapOf>
bool haveTwoTypes(Environments environments, MapOf mapOf) {
  return std::ranges::any_of(environments, [&](const auto* environment) {
    return mapOf(*environment).isFloat != mapOf(*environments[0]).isFloat;
  });
}

const scene::RadianceMap& specularOf(const scene::Environment& environment) {
  return environment.specular[0];
}
const scene::RadianceMap& diffuseOf(const scene::Environment& environment) {
  return environment.diffuse;
}

// How specular maps of different sizes share the levels of one mip chain: the first level of a smaller map is a later
// one of the chain, so it has the same texels as in an image of its own.
struct SpecularChain {
  uint32_t widest = 0, narrowest = ~0u;
  uint32_t levels;  // of each map

  SpecularChain(Environments environments, uint32_t levels) : levels(levels) {
    for (const scene::Environment* environment : environments) {
      widest = std::max(widest, specularOf(*environment).width);
      narrowest = std::min(narrowest, specularOf(*environment).width);
    }
  }
  uint32_t firstOf(uint32_t width) const { return static_cast<uint32_t>(std::bit_width(widest / width) - 1); }
  uint32_t all() const { return levels + firstOf(narrowest); }
};

// Uploads the specular maps with this type of texels. The levels without a map, and the layers of environments whose
// map has the other type, are black.
vk::Image uploadSpecular(vk::Device& device, vk::Uploader& uploader, Environments environments,
                         const SpecularChain& chain, bool isFloat) {
  Texels texels;
  for (const scene::Environment* environment : environments) {
    const std::vector<scene::RadianceMap>& own = environment->specular;
    const uint32_t first = chain.firstOf(own[0].width);
    for (uint32_t level = 0; level < chain.all(); ++level) {
      const uint32_t width = chain.widest >> level;
      if (own[0].isFloat == isFloat && level >= first && level < first + chain.levels)
        append(texels, own[level - first]);
      else
        texels.resize(texels.size() + blackBytes(width, width, isFloat));
    }
  }
  return upload(device, uploader,
                {.format = formatOf(isFloat),
                 .width = chain.widest,
                 .height = chain.widest,
                 .layers = static_cast<uint32_t>(environments.size()),
                 .levels = chain.all(),
                 .name = "environment specular"},
                texels);
}

vk::Image uploadDiffuse(vk::Device& device, vk::Uploader& uploader, Environments environments, bool isFloat) {
  const uint32_t width = environments[0]->diffuse.width, height = environments[0]->diffuse.height;
  Texels texels;
  for (const scene::Environment* environment : environments) {
    if (environment->diffuse.isFloat == isFloat)
      append(texels, environment->diffuse);
    else
      texels.resize(texels.size() + blackBytes(width, height, isFloat));
  }
  return upload(device, uploader,
                {.format = formatOf(isFloat),
                 .width = width,
                 .height = height,
                 .layers = static_cast<uint32_t>(environments.size()),
                 .name = "environment diffuse"},
                texels);
}

vk::Image uploadTable(vk::Device& device, vk::Uploader& uploader, const char* name, VkFormat format, uint32_t size,
                      std::span<const std::byte> texels) {
  return upload(device, uploader, {.format = format, .width = size, .height = size, .name = name}, texels);
}

scene::Environment black() {
  const auto map = [](uint32_t size) { return scene::makeRadianceMap(scene::FloatImage(size, size), false); };
  scene::Environment environment;
  environment.radiance = environment.diffuse = map(1);
  environment.specular = {map(2), map(1)};
  return environment;
}

}  // namespace

GpuEnvironment::GpuEnvironment(vk::Device& device, const scene::Environment* environment)
    : GpuEnvironment(device, std::array{environment}) {}

GpuEnvironment::GpuEnvironment(vk::Device& device, std::span<const scene::Environment* const> given) {
  const scene::Environment nothing = given[0] ? scene::Environment{} : black();
  const std::array none{&nothing};
  const Environments environments = given[0] ? given : Environments(none);
  levels_ = static_cast<uint32_t>(environments[0]->specular.size());
  vk::Uploader uploader(device);
  uploadMaps(device, uploader, environments);
  for (const scene::Environment* environment : environments) {
    const scene::RadianceMap& map = environment->radiance;
    radiance_.push_back(upload(
        device, uploader,
        {.format = formatOf(map.isFloat), .width = map.width, .height = map.height, .name = "environment radiance"},
        map.texels));
  }
  const std::vector<glm::vec2> table = scene::ggxReflectanceTable(kTableSize);
  table_ = uploadTable(device, uploader, "reflectance table", VK_FORMAT_R32G32_SFLOAT, kTableSize,
                       std::as_bytes(std::span(table)));
  std::vector<glm::vec4> lobes;
  for (const glm::vec3& lobe : scene::ggxLobeTable(kLobeTableSize)) lobes.emplace_back(lobe, 0.0f);
  lobes_ = uploadTable(device, uploader, "table of lobes", VK_FORMAT_R32G32B32A32_SFLOAT, kLobeTableSize,
                       std::as_bytes(std::span(lobes)));
  uploader.flush();

  vk::SamplerDesc clamp{.mip = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                        .wrapU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                        .wrapV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
  clampSampler_ = vk::makeSampler(device, clamp);
  clamp.wrapU = VK_SAMPLER_ADDRESS_MODE_REPEAT;
  equirectangularSampler_ = vk::makeSampler(device, clamp);
}

void GpuEnvironment::uploadMaps(vk::Device& device, vk::Uploader& uploader, Environments environments) {
  const SpecularChain chain(environments, levels_);
  const bool twoSpecular = haveTwoTypes(environments, specularOf), twoDiffuse = haveTwoTypes(environments, diffuseOf);
  specular_ =
      uploadSpecular(device, uploader, environments, chain, !twoSpecular && specularOf(*environments[0]).isFloat);
  if (twoSpecular) specularFloats_ = uploadSpecular(device, uploader, environments, chain, true);
  diffuse_ = uploadDiffuse(device, uploader, environments, !twoDiffuse && diffuseOf(*environments[0]).isFloat);
  if (twoDiffuse) diffuseFloats_ = uploadDiffuse(device, uploader, environments, true);
  for (uint32_t layer = 0; layer < environments.size(); ++layer) {
    const scene::Environment& environment = *environments[layer];
    uint32_t map = layer | chain.firstOf(specularOf(environment).width) << shared::kEnvironmentLevelShift;
    if (twoSpecular && specularOf(environment).isFloat) map |= shared::kEnvironmentFloatSpecular;
    if (twoDiffuse && diffuseOf(environment).isFloat) map |= shared::kEnvironmentFloatDiffuse;
    maps_.push_back(map);
  }
}

uint32_t GpuEnvironment::kind() const {
  return specularFloats_ || diffuseFloats_ ? shared::kEnvironmentTwoTypes : shared::kEnvironmentOneType;
}

std::vector<vk::BoundImage> GpuEnvironment::bindings() const {
  const vk::Image &specularFloats = specularFloats_ ? specularFloats_ : specular_,
                  &diffuseFloats = diffuseFloats_ ? diffuseFloats_ : diffuse_;
  return {{specular_.arrayView(), clampSampler_.get()},
          {diffuse_.arrayView(), clampSampler_.get()},
          {table_.view(), clampSampler_.get()},
          {lobes_.view(), clampSampler_.get()},
          {specularFloats.arrayView(), clampSampler_.get()},
          {diffuseFloats.arrayView(), clampSampler_.get()}};
}

}  // namespace latelight::render
