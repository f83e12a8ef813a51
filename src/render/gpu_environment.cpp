#include "render/gpu_environment.h"

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

vk::Image upload(vk::Device& device, vk::Uploader& uploader, const char* name, const scene::HalfImage& image) {
  return upload(device, uploader, name, VK_FORMAT_R16G16B16A16_SFLOAT, image.width, image.height, 1,
                std::as_bytes(std::span(image.pixels)));
}

vk::Image uploadLevels(vk::Device& device, vk::Uploader& uploader, const std::vector<scene::HalfImage>& levels) {
  std::vector<uint16_t> texels;
  for (size_t i = 0; i < levels.size(); ++i) {
    assert(levels[i].width == levels[0].width >> i && "each level is the mip of the one before");
    texels.insert(texels.end(), levels[i].pixels.begin(), levels[i].pixels.end());
  }
  return upload(device, uploader, "environment specular", VK_FORMAT_R16G16B16A16_SFLOAT, levels[0].width,
                levels[0].height, static_cast<uint32_t>(levels.size()), std::as_bytes(std::span(texels)));
}

scene::Environment black() {
  scene::Environment environment;
  environment.radiance = environment.diffuse = {1, 1, std::vector<uint16_t>(4)};
  environment.specular = {{2, 2, std::vector<uint16_t>(16)}, {1, 1, std::vector<uint16_t>(4)}};
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
