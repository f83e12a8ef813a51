#include "render/outputs/outputs.h"

#include <algorithm>
#include <array>
#include <bit>

#include "base/parallel.h"
#include "render/gbuffer/layout.h"
#include "render/outputs/pack_push.h"

namespace latelight::render {

namespace {

using output::Aov;
using namespace shared;  // kPack*

struct Place {
  std::string_view target;
  uint32_t first;  // channel
};

struct Source {
  Origin origin;
  uint32_t packing;  // kPack*
  std::array<Place, 2> places;

  bool isSplit() const { return !places[1].target.empty(); }
};

template <typename... Places>
constexpr Source source(Origin origin, uint32_t packing, Places... places) {
  return {origin, packing, {places...}};
}

// In the order of Aov.
#define AT(...) \
  , Place {     \
    __VA_ARGS__ \
  }
#define PLACES_1(a) AT a
#define PLACES_2(a, b) AT a AT b
#define PLACES_OF(one, two, name, ...) name
constexpr Source kSources[] = {
#define OUTPUT(aov, name, channels, exrChannels, exr, png, background, unit, description, debug, origin, packing, ...) \
  source(Origin::origin, packing PLACES_OF(__VA_ARGS__, PLACES_2, PLACES_1)(__VA_ARGS__)),
#include "output/outputs.def"
};

const Source& sourceOf(Aov aov) {
  return kSources[static_cast<size_t>(aov)];
}

bool holdsIntegers(VkFormat format) {
  return std::string_view(vk::formatName(format)).ends_with("UINT");
}

// Where the host can read it: a CPU device packs it there, others copy it.
graph::BufferId addHostCopy(const Builder& b, graph::BufferId packed) {
  graph::BufferId host = packed;
  if (!b.device.isCpu()) {
    const uint64_t bytes = b.graph.desc(packed).size;
    host = b.graph.create(vk::BufferDesc{.size = bytes, .kind = vk::MemoryKind::Readback, .name = "output, host"});
    b.graph.pass(graph::Stage::Output, "read back", {{packed, graph::Use::CopySource}, {host, graph::Use::CopyTarget}},
                 [=](graph::Context& context) {
                   const VkBufferCopy region{0, 0, bytes};
                   vkCmdCopyBuffer(context.get(), context.buffer(packed).get(), context.buffer(host).get(), 1, &region);
                 });
  }
  b.graph.exports(host, graph::Use::HostRead);
  return host;
}

}  // namespace

Origin originOf(Aov aov) {
  return sourceOf(aov).origin;
}

bool asksFor(const Settings& settings, Origin origin) {
  return std::ranges::any_of(settings.aovs, [&](Aov aov) { return originOf(aov) == origin; });
}

bool showsPicture(const Settings& settings) {
  return settings.display || asksFor(settings, Origin::Picture);
}

uint32_t exactTargets(std::span<const Aov> aovs) {
  const Layout& exact = findLayout("exact");
  uint32_t wanted = 0;
  for (const Aov aov : aovs) {
    if (originOf(aov) != Origin::Surface) continue;
    for (const Place& place : sourceOf(aov).places)
      for (size_t i = 0; i < exact.targets.size(); ++i)
        if (exact.targets[i].name == place.target) wanted |= 1u << i;
  }
  return wanted;
}

uint32_t PackedOutputs::axesOf(uint32_t packing) const {
  if (packing == kPackNormal && settings_.normalFrame == NormalFrame::OpenCv) return kAxesOpenCv;
  if (packing == kPackNormal && settings_.normalFrame == NormalFrame::OpenGl) return kAxesOpenGl;
  return yUp_ ? kAxesGltf : kAxesWorld;
}

void PackedOutputs::add(const Builder& b, Origin origin, const std::function<graph::ImageId(std::string_view)>& image,
                        VkDeviceAddress frame, float scale) {
  for (const Aov aov : settings_.aovs) {
    const Source& from = sourceOf(aov);
    if (from.origin != origin) continue;
    const graph::ImageId first = image(from.places[0].target);
    const graph::ImageId second = from.isSplit() ? image(from.places[1].target) : first;
    const glm::uvec3 size = texels(b.graph, first);
    const uint32_t channels = output::info(aov).channels;
    const bool integers = holdsIntegers(b.graph.desc(first).format);
    const graph::BufferId packed =
        b.graph.create(vk::BufferDesc{.size = uint64_t{4} * channels * size.x * size.y * size.z,
                                      .kind = b.device.isCpu() ? vk::MemoryKind::Readback : vk::MemoryKind::Device,
                                      .name = "output " + std::string(output::info(aov).name)});
    Bindings bindings(b.device);
    bindings.sampled(first);
    if (!integers) bindings.sampled(second);
    const PackPush push{.frame = frame,
                        .packing = from.packing,
                        .channels = channels,
                        .first = from.places[0].first,
                        .second = from.isSplit() ? from.places[1].first : kPackOneImage,
                        .axes = axesOf(from.packing),
                        .scale = scale};
    addCompute(b,
               {.stage = graph::Stage::Output,
                .name = "pack",
                .shader = integers ? "pack_ids.comp" : "pack.comp",
                .bindings = std::move(bindings),
                .size = size,
                .buffers = {{packed, graph::Use::StorageWrite}}},
               [=](graph::Context& context) {
                 PackPush filled = push;
                 filled.values = context.buffer(packed).address();
                 return filled;
               });
    buffers_.emplace_back(aov, addHostCopy(b, packed));
  }
}

void PackedOutputs::read(const graph::Submission& done, graph::BufferId display,
                         std::vector<output::FrameOutput>& pictures) const {
  const size_t perPicture = buffers_.size() + 1;  // the last: display
  parallelFor(pictures.size() * perPicture, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const size_t view = i / perPicture, buffer = i % perPicture;
      output::FrameOutput& picture = pictures[view];
      const size_t pixels = size_t{picture.width} * picture.height;
      if (buffer == buffers_.size()) {
        if (!display) continue;
        const uint8_t* from = done.buffer(display).as<uint8_t>() + view * 4 * pixels;
        picture.display.assign(from, from + 4 * pixels);
        continue;
      }
      const auto [aov, packed] = buffers_[buffer];
      output::AovImage& image = *std::ranges::find(picture.aovs, aov, &output::AovImage::aov);
      const size_t count = pixels * output::info(aov).channels;
      if (output::holdsIds(aov)) {
        const uint32_t* from = done.buffer(packed).as<uint32_t>() + view * count;
        image.ids.assign(from, from + count);
      } else {
        const float* from = done.buffer(packed).as<float>() + view * count;
        image.values.assign(from, from + count);
      }
    }
  });
}

void countShadings(ShadingCounts& counts, const vk::Buffer& surfaces, size_t pixels) {
  counts.pixels += pixels;
  for (size_t i = 0; i < pixels; ++i) {
    // Four bits each, from the lowest.
    const uint32_t shadings = (static_cast<uint32_t>(std::bit_width(surfaces.as<uint32_t>()[i])) + 3) / 4;
    counts.drawn += shadings > 0;
    counts.several += shadings > 1;
    counts.shadings += shadings;
  }
}

}  // namespace latelight::render
