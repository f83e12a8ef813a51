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

void append(Texels& texels, const scene::RadianceMap& map, bool asFloats) {
  const scene::RadianceMap converted =
      asFloats && !map.isFloat ? scene::makeRadianceMap(scene::toFloats(map), true) : scene::RadianceMap{};
  const Texels& from = converted.texels.empty() ? map.texels : converted.texels;
  texels.insert(texels.end(), from.begin(), from.end());
}

using Environments = std::span<const scene::Environment* const>;

// Maps of different sizes share the levels of one mip chain: the first level of a smaller map is a later one of the
// chain, so it has the same texels as in an image of its own. The levels without a map are black.
vk::Image uploadSpecular(vk::Device& device, vk::Uploader& uploader, Environments environments,
                         std::vector<uint32_t>& maps, uint32_t levels) {
  uint32_t widest = 0, narrowest = ~0u;
  bool isFloat = false;
  for (const scene::Environment* environment : environments) {
    widest = std::max(widest, environment->specular[0].width);
    narrowest = std::min(narrowest, environment->specular[0].width);
    isFloat |= environment->specular[0].isFloat;
  }
  const auto levelOf = [&](uint32_t width) { return static_cast<uint32_t>(std::bit_width(widest / width) - 1); };
  const uint32_t all = levels + levelOf(narrowest);
  Texels texels;
  for (uint32_t layer = 0; layer < environments.size(); ++layer) {
    const std::vector<scene::RadianceMap>& own = environments[layer]->specular;
    const uint32_t first = levelOf(own[0].width);
    maps.push_back(layer | first << shared::kEnvironmentLevelShift);
    for (uint32_t level = 0; level < all; ++level) {
      const size_t width = widest >> level;
      if (level < first || level >= first + levels)
        texels.resize(texels.size() + width * width * 4 * (isFloat ? sizeof(float) : sizeof(uint16_t)));
      else
        append(texels, own[level - first], isFloat);
    }
  }
  return upload(device, uploader,
                {.format = formatOf(isFloat),
                 .width = widest,
                 .height = widest,
                 .layers = static_cast<uint32_t>(environments.size()),
                 .levels = all,
                 .name = "environment specular"},
                texels);
}

vk::Image uploadDiffuse(vk::Device& device, vk::Uploader& uploader, Environments environments) {
  bool isFloat = false;
  for (const scene::Environment* environment : environments) isFloat |= environment->diffuse.isFloat;
  Texels texels;
  for (const scene::Environment* environment : environments) append(texels, environment->diffuse, isFloat);
  return upload(device, uploader,
                {.format = formatOf(isFloat),
                 .width = environments[0]->diffuse.width,
                 .height = environments[0]->diffuse.height,
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
  specular_ = uploadSpecular(device, uploader, environments, maps_, levels_);
  diffuse_ = uploadDiffuse(device, uploader, environments);
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

std::vector<vk::BoundImage> GpuEnvironment::bindings() const {
  return {{specular_.arrayView(), clampSampler_.get()},
          {diffuse_.arrayView(), clampSampler_.get()},
          {table_.view(), clampSampler_.get()},
          {lobes_.view(), clampSampler_.get()}};
}

}  // namespace latelight::render
