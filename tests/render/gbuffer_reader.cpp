#include "render/gbuffer_reader.h"

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "render/base/readback.h"
#include "render/frame/view.h"
#include "render/gbuffer/texel.h"
#include "render/post/ambient_occlusion/ambient_occlusion.h"
#include "render/visibility/hardware.h"
#include "scene/half.h"

namespace latelight::render::test {

namespace {

// Returns the code that is nearest to the value; ties may round either way.
uint32_t toUnorm(float value, uint32_t bits) {
  const double levels = (1u << bits) - 1u;
  return static_cast<uint32_t>(std::lround(std::clamp(double{value}, 0.0, 1.0) * levels));
}

}  // namespace

TargetValue storedValue(VkFormat format, const TargetValue& value) {
  std::byte texel[16]{};
  uint32_t word = 0;
  switch (format) {
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
      for (int i = 0; i < 4; ++i) {
        const bool coded = format == VK_FORMAT_R8G8B8A8_SRGB && i < 3;
        word |= toUnorm(coded ? shared::srgbFromLinear(shared::saturate(value.f[i])) : value.f[i], 8) << (8 * i);
      }
      break;
    case VK_FORMAT_R16G16_UNORM:
      word = toUnorm(value.f.x, 16) | toUnorm(value.f.y, 16) << 16;
      break;
    case VK_FORMAT_A2B10G10R10_UNORM_PACK32:
      word = toUnorm(value.f.x, 10) | toUnorm(value.f.y, 10) << 10 | toUnorm(value.f.z, 10) << 20 |
             toUnorm(value.f.w, 2) << 30;
      break;
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R16G16B16A16_SFLOAT: {
      uint16_t halves[4];
      for (int i = 0; i < 4; ++i) halves[i] = scene::halfFromFloat(value.f[i]);
      std::memcpy(texel, halves, sizeof(halves));
      return decodeTexel(format, texel);
    }
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_R32G32_UINT:
    case VK_FORMAT_R32G32B32A32_UINT:
      return value;
    default:
      throw std::logic_error(std::string("teach storedValue the format ") + vk::formatName(format));
  }
  std::memcpy(texel, &word, sizeof(word));
  return decodeTexel(format, texel);
}

shared::Surface ReadGbuffer::surface(size_t pixel) const {
  shared::GbufferContext context{};
  context.view = view;
  context.pixel = {static_cast<float>(pixel % width) + 0.5f, static_cast<float>(pixel / width) + 0.5f};
  context.depth = depth[pixel];
  context.ao = before[pixel].w;
  context.normalEncoding = normalEncoding;
  context.normalSpace = normalSpace;
  context.positionMethod = positionMethod;
  std::vector<TargetValue> values;
  for (const std::vector<TargetValue>& target : targets) values.push_back(target[pixel]);
  return layout->unpack(values, context);
}

GbufferReader::GbufferReader(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment)
    : frames_(device, scene, environment) {}

ReadGbuffer GbufferReader::read(const FrameConfig& setup, const scene::Camera& camera, uint32_t width, uint32_t height,
                                const LightSettings& light) {
  ReadGbuffer result{.layout = setup.layout,
                     .normalEncoding = setup.normalEncoding,
                     .normalSpace = setup.normalSpace,
                     .positionMethod = setup.positionMethod,
                     .view = makeView(camera, width, height),
                     .width = width,
                     .height = height};
  frames_.shine(light.firstLight, light.lightCount);
  graph::Graph graph;
  const FrameContext f = frames_.frame(graph, setup, {result.view},
                                       {light.exposure, light.environmentIntensity, light.environmentRotation});
  Gbuffer gbuffer = gbufferOf(addVisibility(f));
  gbuffer.light = createTarget(f, kLightFormat, "light");
  gbuffer.sampleLight = gbuffer.light;
  gbuffer.lightCounts = graph.create(vk::ImageDesc{.format = kCountsFormat, .width = 1, .height = 1, .layers = 1});
  gbuffer = addGbuffer(f, std::move(gbuffer));
  std::vector<graph::BufferId> targets;
  for (graph::ImageId target : gbuffer.targets) targets.push_back(addReadback(graph, target));
  const graph::BufferId depth = addReadback(graph, gbuffer.depth), before = addReadback(graph, gbuffer.light);
  gbuffer.ambientOcclusion = addAmbientOcclusion(f, gbuffer);
  setup.lighting->add(f, gbuffer);
  const graph::BufferId after = addReadback(graph, gbuffer.light);
  const graph::Submission& done = frames_.run(graph);

  const size_t pixels = size_t{width} * height;
  const auto decode = [&](graph::BufferId buffer, VkFormat format) {
    std::vector<TargetValue> values(pixels);
    for (size_t i = 0; i < pixels; ++i)
      values[i] = decodeTexel(format, done.buffer(buffer).mapped() + i * vk::texelBytes(format));
    return values;
  };
  for (size_t i = 0; i < targets.size(); ++i)
    result.targets.push_back(decode(targets[i], setup.layout->format(i, setup.normalEncoding)));
  for (const TargetValue& value : decode(before, kLightFormat)) result.before.push_back(value.f);
  for (const TargetValue& value : decode(after, kLightFormat)) result.after.push_back(value.f);
  const float* depths = done.buffer(depth).as<float>();
  result.depth.assign(depths, depths + pixels);
  return result;
}

}  // namespace latelight::render::test
