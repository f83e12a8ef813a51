#include "render/aov_read.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "base/parallel.h"
#include "render/post/resolve.h"
#include "scene/half.h"

namespace latelight::render {

namespace {

using glm::vec3;
using output::Aov;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Where each data output lies in the layout `exact`: target, first channel, channels. In the order of Aov; an output
// that lies in two targets has two entries, in the order of its own channels.
struct Source {
  Aov aov;
  const char* target;
  uint32_t first, count;
};
constexpr Source kSources[] = {
    {Aov::Depth, "depth", 0, 1},
    {Aov::Distance, "depth", 0, 1},
    {Aov::Normal, "normal", 0, 3},
    {Aov::GeoNormal, "geonormal", 0, 3},
    {Aov::Position, "position", 0, 3},
    {Aov::Albedo, "albedo", 0, 3},
    {Aov::Metallic, "geonormal", 3, 1},
    {Aov::Roughness, "normal", 3, 1},
    {Aov::Emissive, "emissive", 0, 3},
    {Aov::Ao, "position", 3, 1},
    {Aov::Id, "ids", 0, 1},
    {Aov::Part, "ids", 1, 1},
    {Aov::Material, "ids", 2, 1},
    {Aov::Uv, "f0", 3, 1},
    {Aov::Uv, "emissive", 3, 1},
    {Aov::Motion, "motion", 0, 4},  // a target beside the layout's
};
static_assert(std::ranges::is_sorted(kSources, {}, &Source::aov));

std::span<const Source> sourcesOf(Aov aov) {
  const auto [first, last] = std::ranges::equal_range(kSources, aov, {}, &Source::aov);
  return {first, last};
}

vec3 gltfFromWorld(vec3 v) {
  return {v.x, v.z, -v.y};
}
vec3 openCvFromView(vec3 v) {
  return {v.x, -v.z, v.y};
}
vec3 openGlFromView(vec3 v) {
  return {v.x, v.z, -v.y};
}

// How a direction leaves.
std::function<vec3(vec3)> normalTransform(const shared::View& view, NormalFrame frame, bool yUp) {
  glm::mat3 toView(view.worldToView);
  switch (frame) {
    case NormalFrame::OpenCv:
      return [=](vec3 n) { return openCvFromView(toView * n); };
    case NormalFrame::OpenGl:
      return [=](vec3 n) { return openGlFromView(toView * n); };
    case NormalFrame::World:
      break;
  }
  if (yUp) return gltfFromWorld;
  return [](vec3 n) { return n; };
}

template <typename F>
void forEachPixel(const output::AovImage& image, F&& body) {
  parallelFor(size_t{image.width} * image.height, 1 << 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) body(i);
  });
}

// Metres from device depth: planar, or along the pixel's ray.
void readDepth(output::AovImage& image, const float* device, const shared::View& view) {
  const bool alongRay = image.aov == Aov::Distance;
  image.values.resize(size_t{image.width} * image.height);
  forEachPixel(image, [&](size_t i) {
    if (device[i] == 0.0f) {
      image.values[i] = kInfinity;
      return;
    }
    float depth = shared::viewDepth(view.projection, device[i]);
    glm::vec2 pixel(static_cast<float>(i % image.width) + 0.5f, static_cast<float>(i / image.width) + 0.5f);
    image.values[i] =
        alongRay ? depth * glm::length(shared::viewRay(view.projection, shared::pixelToNdc(pixel, view.size))) : depth;
  });
}

}  // namespace

void readColor(output::FrameOutput& to, const vk::Buffer& from, size_t view, bool isFloat, float scale) {
  for (output::AovImage& image : to.aovs) {
    if (image.aov != Aov::Color) continue;
    const size_t count = size_t{4} * image.width * image.height;
    image.values.resize(count);
    parallelFor(count, 1 << 18, [&](size_t begin, size_t end) {
      const uint16_t* halves = from.as<uint16_t>() + view * count;
      const float* floats = from.as<float>() + view * count;
      for (size_t i = begin; i < end; ++i)
        image.values[i] = isFloat ? floats[i] * scale : scene::floatFromHalf(halves[i]);
    });
  }
}

bool isData(Aov aov) {
  return !sourcesOf(aov).empty();
}

bool isLightCount(Aov aov) {
  return aov == Aov::LightsTested || aov == Aov::LightsUsed;
}

void readLightCounts(output::FrameOutput& to, const vk::Buffer& from, size_t view) {
  for (output::AovImage& image : to.aovs) {
    if (!isLightCount(image.aov)) continue;
    const size_t pixels = size_t{image.width} * image.height;
    const float* counts = from.as<float>() + 4 * view * pixels + (image.aov == Aov::LightsTested ? 0 : 1);
    image.values.resize(pixels);
    forEachPixel(image, [&](size_t i) { image.values[i] = counts[4 * i]; });
  }
}

namespace {

// Of a texel of kSurfacesFormat: four bits each, from the lowest.
uint32_t surfaceCount(uint32_t surfaces) {
  return (static_cast<uint32_t>(std::bit_width(surfaces)) + 3) / 4;
}

}  // namespace

void readSampleCounts(output::FrameOutput& to, const vk::Buffer& from, size_t view, bool surfaces) {
  for (output::AovImage& image : to.aovs) {
    if (image.aov != Aov::Samples) continue;
    const size_t pixels = size_t{image.width} * image.height;
    image.values.resize(pixels);
    const uint32_t* texels = from.as<uint32_t>() + view * pixels;  // a depth above 0 has bits set, too
    forEachPixel(image, [&](size_t i) {
      image.values[i] = static_cast<float>(surfaces ? surfaceCount(texels[i]) : uint32_t{texels[i] != 0});
    });
  }
}

void countShadings(ShadingCounts& counts, const vk::Buffer& surfaces, size_t pixels) {
  counts.pixels += pixels;
  for (size_t i = 0; i < pixels; ++i) {
    const uint32_t shadings = surfaceCount(surfaces.as<uint32_t>()[i]);
    counts.drawn += shadings > 0;
    counts.several += shadings > 1;
    counts.shadings += shadings;
  }
}

uint32_t exactTargets(std::span<const Aov> aovs) {
  const Layout& exact = findLayout("exact");
  uint32_t wanted = 0;
  for (const Aov aov : aovs)
    for (const Source& source : sourcesOf(aov))
      for (size_t i = 0; i < exact.targets.size(); ++i)
        if (std::strcmp(exact.targets[i].name, source.target) == 0) wanted |= 1u << i;
  return wanted;
}

DataReadback::DataReadback(graph::Graph& graph, const Layout& exact, const Gbuffer& gbuffer, graph::ImageId motion,
                           std::span<const Aov> aovs) {
  auto image = [&](std::string_view target) {
    for (size_t i = 0; i < exact.targets.size(); ++i)
      if (exact.targets[i].name == target) return gbuffer.targets[i];
    return target == "motion" ? motion : gbuffer.depth;
  };
  for (Aov aov : aovs)
    for (const Source& source : sourcesOf(aov))
      if (!buffers_.contains(source.target)) buffers_[source.target] = addReadback(graph, image(source.target));
}

void DataReadback::read(const graph::Submission& done, const shared::View& view, size_t layer, const Settings& settings,
                        bool yUp, output::FrameOutput& to) const {
  for (output::AovImage& image : to.aovs) {
    const size_t pixels = size_t{image.width} * image.height;
    const uint32_t channels = output::info(image.aov).channels;
    uint32_t channel = 0;  // of the output: where this source's begin
    for (const Source& source : sourcesOf(image.aov)) {
      const vk::Buffer& buffer = done.buffer(buffers_.at(source.target));
      if (std::strcmp(source.target, "depth") == 0) {
        readDepth(image, buffer.as<float>() + layer * pixels, view);
        continue;
      }
      const size_t begin = layer * pixels * 4 + source.first;  // every other target has 4 channels
      if (output::holdsIds(image.aov)) {
        image.ids.resize(pixels);
        const uint32_t* ids = buffer.as<uint32_t>() + begin;
        forEachPixel(image, [&](size_t i) { image.ids[i] = ids[4 * i]; });
        continue;
      }
      image.values.resize(pixels * channels);
      const float* texels = buffer.as<float>() + begin;
      const bool direction = image.aov == Aov::Normal || image.aov == Aov::GeoNormal;
      if (direction || image.aov == Aov::Position) {
        auto transform = normalTransform(view, direction ? settings.normalFrame : NormalFrame::World, yUp);
        forEachPixel(image, [&](size_t i) {
          vec3 v = transform(vec3(texels[4 * i], texels[4 * i + 1], texels[4 * i + 2]));
          std::memcpy(&image.values[3 * i], &v, sizeof(v));
        });
        continue;
      }
      forEachPixel(image, [&](size_t i) {
        for (uint32_t c = 0; c < source.count; ++c) image.values[channels * i + channel + c] = texels[4 * i + c];
      });
      channel += source.count;
    }
  }
}

}  // namespace latelight::render
