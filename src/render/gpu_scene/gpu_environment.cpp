#include "render/gpu_scene/gpu_environment.h"

#include <cassert>

namespace latelight::render {

namespace {

constexpr uint32_t kTableSize = 32, kLobeTableSize = 16;

vk::Image upload(vk::Device& device, vk::Uploader& uploader, const char* name, VkFormat format, uint32_t width,
                 uint32_t height, uint32_t levels, std::span<const std::byte> texels) {
  vk::Image image(device, {.format = format,
                           .width = width,
                           .height = height,
                           .levels = levels,
                           .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                           .name = name});
  uploader.upload(image, texels);
  return image;
}

VkFormat formatOf(const scene::RadianceMap& map) {
  return map.isFloat ? VK_FORMAT_R32G32B32A32_SFLOAT : VK_FORMAT_R16G16B16A16_SFLOAT;
}

vk::Image upload(vk::Device& device, vk::Uploader& uploader, const char* name, const scene::RadianceMap& map) {
  return upload(device, uploader, name, formatOf(map), map.width, map.height, 1, map.texels);
}

vk::Image uploadLevels(vk::Device& device, vk::Uploader& uploader, const std::vector<scene::RadianceMap>& levels) {
  decltype(scene::RadianceMap::texels) texels;
  for (size_t i = 0; i < levels.size(); ++i) {
    assert(levels[i].width == levels[0].width >> i && levels[i].isFloat == levels[0].isFloat &&
           "each level is the mip of the one before");
    texels.insert(texels.end(), levels[i].texels.begin(), levels[i].texels.end());
  }
  return upload(device, uploader, "environment specular", formatOf(levels[0]), levels[0].width, levels[0].height,
                static_cast<uint32_t>(levels.size()), texels);
}

scene::Environment black() {
  const auto map = [](uint32_t size) { return scene::makeRadianceMap(scene::FloatImage(size, size), false); };
  scene::Environment environment;
  environment.radiance = environment.diffuse = map(1);
  environment.specular = {map(2), map(1)};
  return environment;
}

}  // namespace

GpuEnvironment::GpuEnvironment(vk::Device& device, const scene::Environment* given) {
  const scene::Environment nothing = given ? scene::Environment{} : black();
  const scene::Environment& environment = given ? *given : nothing;
  vk::Uploader uploader(device);
  specular_ = uploadLevels(device, uploader, environment.specular);
  diffuse_ = upload(device, uploader, "environment diffuse", environment.diffuse);
  radiance_ = upload(device, uploader, "environment radiance", environment.radiance);
  const std::vector<glm::vec2> table = scene::ggxReflectanceTable(kTableSize);
  table_ = upload(device, uploader, "reflectance table", VK_FORMAT_R32G32_SFLOAT, kTableSize, kTableSize, 1,
                  std::as_bytes(std::span(table)));
  std::vector<glm::vec4> lobes;
  for (const glm::vec3& lobe : scene::ggxLobeTable(kLobeTableSize)) lobes.emplace_back(lobe, 0.0f);
  lobes_ = upload(device, uploader, "table of lobes", VK_FORMAT_R32G32B32A32_SFLOAT, kLobeTableSize, kLobeTableSize, 1,
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
  return {{specular_.view(), clampSampler_.get()},
          {diffuse_.view(), clampSampler_.get()},
          {table_.view(), clampSampler_.get()},
          {lobes_.view(), clampSampler_.get()}};
}

}  // namespace latelight::render
