#include "render/outputs/raw_read.h"

#include <limits>

#include "base/parallel.h"
#include "render/base/readback.h"
#include "render/gbuffer/texel.h"
#include "vk/resources.h"

namespace latelight::render {

namespace {

using output::TargetKind;

TargetKind targetKindOf(VkFormat format) {
  switch (vk::formatKind(format)) {
    case vk::FormatKind::Srgb:
      return TargetKind::Srgb;
    case vk::FormatKind::Sfloat:
    case vk::FormatKind::Ufloat:
      return TargetKind::Float;
    case vk::FormatKind::Uint:
      return TargetKind::Words;
    default:
      return TargetKind::Unorm;
  }
}

output::RawTarget describe(const char* name, const char* channels, VkFormat format) {
  return {.name = name, .channels = channels, .kind = targetKindOf(format), .count = vk::channelCount(format)};
}

void decode(output::RawTarget& target, VkFormat format, const std::byte* texels, size_t pixels) {
  const bool words = target.kind == TargetKind::Words;
  (words ? target.words.resize(4 * pixels) : target.values.resize(4 * pixels));
  const size_t bytes = vk::texelBytes(format);
  parallelFor(pixels, 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const TargetValue value = decodeTexel(format, texels + i * bytes);
      for (int c = 0; c < 4; ++c) {
        if (words)
          target.words[4 * i + static_cast<size_t>(c)] = value.u[c];
        else
          target.values[4 * i + static_cast<size_t>(c)] = value.f[c];
      }
    }
  });
}

}  // namespace

RawReadback::RawReadback(graph::Graph& graph, const Layout& layout, uint32_t normalEncoding, const Gbuffer& gbuffer)
    : depth_(addReadback(graph, gbuffer.depth)) {
  for (size_t i = 0; i < layout.targets.size(); ++i) {
    const VkFormat format = layout.format(i, normalEncoding);
    targets_.push_back({describe(layout.targets[i].name, layout.targets[i].channels, format), format,
                        addReadback(graph, gbuffer.targets[i])});
  }
  output::RawTarget light = describe("light", "rgb: lit radiance", kLightFormat);
  light.kind = TargetKind::Light;
  targets_.push_back({std::move(light), kLightFormat, addReadback(graph, gbuffer.light)});
}

output::RawGbuffer RawReadback::read(const graph::Submission& done, const shared::View& view) const {
  output::RawGbuffer gbuffer{.width = static_cast<uint32_t>(view.size.x), .height = static_cast<uint32_t>(view.size.y)};
  const size_t pixels = size_t{gbuffer.width} * gbuffer.height;
  for (const Target& target : targets_) {
    gbuffer.targets.push_back(target.described);
    decode(gbuffer.targets.back(), target.format, done.buffer(target.buffer).mapped(), pixels);
  }
  const float* depth = done.buffer(depth_).as<float>();
  gbuffer.depth.resize(pixels);
  for (size_t i = 0; i < pixels; ++i)
    gbuffer.depth[i] =
        depth[i] == 0.0f ? std::numeric_limits<float>::infinity() : shared::viewDepth(view.projection, depth[i]);
  return gbuffer;
}

}  // namespace latelight::render
