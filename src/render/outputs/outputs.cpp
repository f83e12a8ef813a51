#include "render/outputs/outputs.h"

#include <algorithm>
#include <array>
#include <bit>

#include "base/parallel.h"
#include "render/base/readback.h"
#include "render/frame/frame.h"
#include "render/gbuffer/layout.h"
#include "render/outputs/format_push.h"
#include "render/outputs/pack_push.h"
#include "shared/samples.h"

namespace latelight::render {

namespace {

using output::Aov;
using namespace shared;  // kPack*, kTexture*

struct Place {
  std::string_view target;
  uint32_t first;  // channel
};

struct Source {
  Origin origin;
  uint32_t packing;   // kPack*
  uint32_t textures;  // material texture slots
  std::array<Place, 2> places;

  bool isSplit() const { return !places[1].target.empty(); }
};

template <typename... Places>
constexpr Source source(Origin origin, uint32_t packing, uint32_t textures, Places... places) {
  return {origin, packing, textures, {places...}};
}

// One source per output, in the order of Aov.
#define AT(...) \
  , Place {     \
    __VA_ARGS__ \
  }
#define SLOTS_1(a) AT a
#define SLOTS_2(a, b) AT a AT b
#define SLOTS_OF(one, two, name, ...) name
constexpr Source kSources[] = {
#define OUTPUT(aov, name, channels, exrChannels, exr, png, background, unit, description, debug, origin, packing, \
               textures, ...)                                                                                     \
  source(Origin::origin, packing, textures SLOTS_OF(__VA_ARGS__, SLOTS_2, SLOTS_1)(__VA_ARGS__)),
#include "output/outputs.def"
};

static_assert(std::ranges::count(kSources, Origin::Surface, &Source::origin) <= kSurfaceOutputs);

const Source& sourceOf(Aov aov) {
  return kSources[static_cast<size_t>(aov)];
}

bool holdsIntegers(VkFormat format) {
  return vk::formatKind(format) == vk::FormatKind::Uint;
}

}  // namespace

Origin originOf(Aov aov) {
  return sourceOf(aov).origin;
}

bool requestsOutput(const Settings& settings, Origin origin) {
  return std::ranges::any_of(settings.aovs, [&](Aov aov) { return originOf(aov) == origin; });
}

bool requestsSurfaces(const Settings& settings) {
  return requestsOutput(settings, Origin::Surface) || requestsOutput(settings, Origin::Motion) ||
         requestsOutput(settings, Origin::Coordinates);
}

bool showsPicture(const Settings& settings) {
  return settings.display || requestsOutput(settings, Origin::Picture) || requestsOutput(settings, Origin::Sensor);
}

uint32_t textureSlots(const Settings& settings) {
  uint32_t slots = settings.display ? ~0u : 0;
  for (const Aov aov : settings.aovs) slots |= sourceOf(aov).textures;
  return slots;
}

uint64_t bytesPerPixel(const Settings& settings) {
  uint64_t bytes = settings.display ? 4 : 0;
  for (const Aov aov : settings.aovs) bytes += 4 * output::info(aov).channels;
  return bytes;
}

uint32_t PackedOutputs::axesOf(uint32_t packing) const {
  if (packing == kPackNormal && settings_.normalFrame == NormalFrame::OpenCv) return kAxesOpenCv;
  if (packing == kPackNormal && settings_.normalFrame == NormalFrame::OpenGl) return kAxesOpenGl;
  return yUp_ ? kAxesGltf : kAxesWorld;
}

// An exported array is imported as read and written, so that the results of its other views are preserved.
ResultTarget PackedOutputs::place(const Builder& b, std::optional<Aov> aov, uint32_t texelBytes, glm::uvec3 size) {
  ResultTarget place;
  const auto array = std::ranges::find(arrays_.arrays, aov, &ExportedArray::aov);
  const bool converted = array != arrays_.arrays.end() && array->converted;
  if (arrays_.arrays.empty() || converted) {
    const std::string name = aov ? "output " + std::string(output::info(*aov).name) : "picture";
    place = createResult(b, name, uint64_t{texelBytes} * size.x * size.y, size.z);
    if (converted) {
      conversions_.push_back({&*array, place, size});
      return place;
    }
  } else {
    const uint64_t viewBytes = viewBytesOf(*array);
    place = {.buffer = b.graph.import(array->memory->buffer, graph::Use::StorageReadWrite),
             .use = graph::Use::StorageReadWrite,
             .offset = arrays_.firstView * viewBytes + arrays_.firstRow * array->rowBytes(),
             .viewBytes = viewBytes};
  }
  results_.push_back({aov, place.buffer});
  return place;
}

void PackedOutputs::add(const Builder& b, Origin origin, const std::function<graph::ImageId(std::string_view)>& image,
                        VkDeviceAddress frame, float scale) {
  for (const Aov aov : settings_.aovs) {
    const Source& from = sourceOf(aov);
    if (from.origin != origin) continue;
    const graph::ImageId first = image(from.places[0].target);
    const graph::ImageId second = from.isSplit() ? image(from.places[1].target) : first;
    glm::uvec3 size = texels(b.graph, first);
    const uint32_t channels = output::info(aov).channels;
    const bool integers = holdsIntegers(b.graph.desc(first).format);
    const uint32_t samples = from.packing == kPackCount ? settings_.aa.samples : 1;
    if (integers) size.z /= surfaceLayers(samples);
    const ResultTarget to = place(b, aov, 4 * channels, size);
    Bindings bindings(b.device);
    bindings.sampled(first);
    if (!integers) bindings.sampled(second);
    const PackPush push{.frame = frame,
                        .viewBytes = to.viewBytes,
                        .channels = channels,
                        .first = from.places[0].first,
                        .second = from.isSplit() ? from.places[1].first : kPackOneImage,
                        .axes = axesOf(from.packing),
                        .scale = scale};
    addCompute(
        b,
        {.stage = graph::Stage::Output,
         .name = "pack",
         .shader = integers ? "pack_ids.comp" : "pack.comp",
         .bindings = std::move(bindings),
         .size = size,
         .constants = {{kSamplesConstant, samples}, {kLensConstant, lens_ ? 1u : 0u}, {kPackingConstant, from.packing}},
         .buffers = {{to.buffer, to.use}}},
        [=](graph::Context& context) {
          PackPush filled = push;
          filled.values = to.address(context);
          return filled;
        });
  }
}

SurfaceOutputs PackedOutputs::addSurfaces(const Builder& b, glm::uvec3 size) {
  const Layout& exact = findLayout("exact");
  const auto targetOf = [&](std::string_view name) {
    const auto found = std::ranges::find(exact.targets, name, &LayoutTarget::name);
    return static_cast<uint32_t>(found - exact.targets.begin());
  };
  SurfaceOutputs outputs;
  for (const Aov aov : settings_.aovs) {
    const Source& from = sourceOf(aov);
    if (from.origin != Origin::Surface) continue;
    const uint32_t channels = output::info(aov).channels;
    const bool depth = from.places[0].target == "depth";
    outputs.places.push_back(place(b, aov, 4 * channels, size));
    outputs.bits.push_back(
        surfaceOutputBits({.packing = from.packing,
                           .axes = axesOf(from.packing),
                           .channels = channels,
                           .target = depth ? 0 : targetOf(from.places[0].target),
                           .first = from.places[0].first,
                           .second = from.isSplit() ? targetOf(from.places[1].target) : kPackOneTarget,
                           .secondFirst = from.places[1].first}));
  }
  return outputs;
}

std::vector<graph::BufferId> PackedOutputs::buffers() const {
  std::vector<graph::BufferId> buffers;
  for (const Result& result : results_) buffers.push_back(result.buffer);
  return buffers;
}

// Adds the pass that converts a packed output to the format of its array.
void PackedOutputs::addConversion(const Builder& b, const Conversion& conversion) {
  const ExportedArray& array = *conversion.array;
  const glm::uvec3 size = conversion.size;
  const graph::BufferId target = b.graph.import(array.memory->buffer, graph::Use::StorageReadWrite);
  const bool ids = array.aov && output::holdsIntegers(*array.aov), planar = array.channelsFirst && array.channels > 1;
  const uint32_t pixels = size.x * size.y, elements = planar ? pixels : pixels * array.channels;
  const uint32_t words = elements * array.elementBytes / 4 + 2, stride = std::min(words, 1u << 20);
  const uint64_t viewBytes = viewBytesOf(array);
  const uint64_t offset = arrays_.firstView * viewBytes + arrays_.firstRow * array.rowBytes();
  const FormatPush push{.sourceViewBytes = conversion.packed.viewBytes,
                        .targetViewBytes = viewBytes,
                        .planeBytes = uint64_t{array.elementBytes} * array.columns * array.rows,
                        .elements = elements,
                        .stride = stride};
  const uint32_t format = !array.aov                ? kFormatByte
                          : array.elementBytes == 4 ? kFormatWord
                          : ids                     ? kFormatShort
                                                    : kFormatHalf;
  addCompute(b,
             {.stage = graph::Stage::Output,
              .name = "format",
              .shader = "format.comp",
              .bindings = Bindings(b.device),
              .size = {stride, planar ? array.channels : 1, size.z},
              .constants = {{kElementFormatConstant, format},
                            {kSourceChannelsConstant, array.aov ? array.channels : 1},
                            {kChannelsConstant, array.channels},
                            {kPlanarConstant, planar ? 1u : 0u}},
              .buffers = {{conversion.packed.buffer, graph::Use::StorageRead}, {target, graph::Use::StorageReadWrite}},
              .groupX = kFormatGroup,
              .groupY = 1},
             [=, packed = conversion.packed](graph::Context& context) {
               FormatPush filled = push;
               filled.source = packed.address(context);
               filled.target = context.buffer(target).address() + offset;
               return filled;
             });
  results_.push_back({array.aov, target});
}

void PackedOutputs::exportResults(const Builder& b, Results results) {
  for (const Conversion& conversion : conversions_) addConversion(b, conversion);
  if (results == Results::Exported) {
    for (const graph::BufferId buffer : buffers()) b.graph.exports(buffer, graph::Use::HostRead);
    return;
  }
  onHost_ = results == Results::ToHost || b.device.isCpu();
  if (!onHost_) return storeResults(b, buffers());
  const std::vector<graph::BufferId> host = addReadback(b, buffers());
  for (size_t i = 0; i < results_.size(); ++i) results_[i].buffer = host[i];
}

void PackedOutputs::read(vk::Device& device, graph::Executor& executor, const graph::Submission& done,
                         std::vector<output::FrameOutput>& pictures) const {
  if (onHost_) return unpack(done, buffers(), pictures);
  graph::Graph graph(executor);
  std::vector<graph::BufferId> imported;
  for (const graph::BufferId buffer : buffers())
    imported.push_back(graph.import(done.buffer(buffer), graph::Use::CopySource));
  const std::vector<graph::BufferId> host = addReadback({device, graph}, imported);
  const graph::Submission copied = executor.submit(graph, graph.compile());
  copied.wait();
  unpack(copied, host, pictures);
}

void PackedOutputs::unpack(const graph::Submission& done, std::span<const graph::BufferId> buffers,
                           std::vector<output::FrameOutput>& pictures) const {
  parallelFor(pictures.size() * results_.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const size_t view = i / results_.size(), result = i % results_.size();
      output::FrameOutput& picture = pictures[view];
      const size_t pixels = size_t{picture.width} * picture.height;
      const auto assign = [&]<typename T>(std::vector<T>& values, size_t channels) {
        const T* from = done.buffer(buffers[result]).as<T>() + view * channels * pixels;
        values.assign(from, from + channels * pixels);
      };
      const std::optional<Aov> aov = results_[result].aov;
      if (!aov) {
        assign(picture.display, 4);
        continue;
      }
      output::AovImage& image = *std::ranges::find(picture.aovs, *aov, &output::AovImage::aov);
      if (output::holdsIntegers(*aov))
        assign(image.ids, output::info(*aov).channels);
      else
        assign(image.values, output::info(*aov).channels);
    }
  });
}

void countShadings(ShadingCounts& counts, const vk::Buffer& surfaces, size_t pixels, size_t views, uint32_t samples) {
  const uint32_t layers = shared::surfaceLayers(samples);
  counts.pixels += pixels * views;
  for (size_t i = 0; i < pixels * views; ++i) {
    const uint32_t* first = surfaces.as<uint32_t>() + i / pixels * layers * pixels + i % pixels;
    uint32_t shadings = 0;
    for (uint32_t layer = 0; layer < layers; ++layer)
      shadings += (static_cast<uint32_t>(std::bit_width(first[layer * pixels])) + samples - 1) / samples;
    counts.drawn += shadings > 0;
    counts.several += shadings > 1;
    counts.shadings += shadings;
  }
}

}  // namespace latelight::render
