#include "render/outputs/raw_read.h"

#include <limits>

#include "base/parallel.h"
#include "render/base/readback.h"
#include "render/gbuffer/texel.h"
#include "vk/resources.h"

namespace latelight::render {

namespace {

using output::TargetKind;

// Derives the number and kind of channels from the format's name: R8G8B8A8_SRGB has four.
output::RawTarget describe(const char* name, const char* channels, VkFormat format) {
  const std::string text = vk::formatName(format);
  TargetKind kind = TargetKind::Unorm;
  if (text.find("SRGB") != text.npos) kind = TargetKind::Srgb;
  if (text.find("SFLOAT") != text.npos) kind = TargetKind::Float;
  if (text.find("UINT") != text.npos) kind = TargetKind::Words;
  uint32_t count = 0;
  for (const char letter : {'R', 'G', 'B', 'A'})
    for (size_t i = 0; i + 1 < text.size(); ++i) count += text[i] == letter && text[i + 1] >= '0' && text[i + 1] <= '9';
  return {.name = name, .channels = channels, .kind = kind, .count = count};
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
