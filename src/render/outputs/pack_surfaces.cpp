#include "render/outputs/pack_surfaces.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <set>

#include "render/base/pixel_group.h"
#include "render/frame/covered_tiles.h"
#include "render/outputs/data_words.h"
#include "render/outputs/pack_push.h"

namespace latelight::render {

using namespace shared;  // kPack*, kAxes*, SurfaceOutput

namespace {

vk::ConstantId dataWordsConstant(size_t image) {
  return vk::ConstantId{static_cast<uint32_t>(kFirstDataWordsConstant) + static_cast<uint32_t>(image)};
}

bool isDepth(const SurfaceOutput& output) {
  return output.packing == kPackDepth || output.packing == kPackDistance;
}

// Returns the values that an output has where nothing is visible; empty if they depend on the view.
std::vector<uint32_t> backgroundOf(const SurfaceOutput& output) {
  constexpr uint32_t kMinusZero = 1u << 31;
  if (isDepth(output)) return {std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity())};
  if (output.packing == kPackValues || (output.packing == kPackNormal && output.axes == kAxesWorld))
    return std::vector<uint32_t>(output.channels, 0);
  // packedInAxes() of pack.glsl negates the third channel.
  if (output.packing == kPackNormal && output.axes == kAxesGltf) return {0, 0, kMinusZero};
  return {};
}

// Adds the passes that fill the outputs with the values that they have where nothing is visible. Returns false, and
// adds none, if these depend on the view.
bool fillsBackgrounds(const FrameContext& f, const SurfaceOutputs& outputs) {
  std::vector<std::vector<uint32_t>> backgrounds;
  for (const uint32_t bits : outputs.bits) backgrounds.push_back(backgroundOf(surfaceOutputOf(bits)));
  if (std::ranges::any_of(backgrounds, &std::vector<uint32_t>::empty)) return false;
  for (size_t i = 0; i < outputs.places.size(); ++i)
    addFill(f, outputs.places[i], sizeof(uint32_t) * backgrounds[i].size() * f.width * f.height, f.viewCount(),
            backgrounds[i]);
  return true;
}

// Packs the outputs from `first` on, at most kPackedAtOnce of them.
void addPack(const FrameContext& f, const VisibilityBuffer& visible, const SurfaceOutputs& outputs, size_t first,
             std::span<const uint32_t> words, std::span<const graph::ImageId> images, graph::BufferId covered) {
  ComputePass pass{.stage = graph::Stage::Output,
                   .name = "pack",
                   .shader = images.empty() ? "pack_depths.comp" : "pack_surfaces.comp",
                   .bindings = Bindings(f.device).sampled(visible.pixels),
                   .size = f.pixels(),
                   .constants = {{kLensConstant, f.setup.lens ? 1u : 0u}},
                   .groupX = kPixelGroupX,
                   .groupY = kPixelGroupY};
  if (!images.empty())  // every binding requires an image
    for (size_t i = 0; i < kMaxDataImages; ++i) pass.bindings.sampled(images[std::min(i, images.size() - 1)]);
  addDataWords(words, pass.constants);
  const std::vector<ResultTarget> places = packInSlots(outputs, first, bool(covered), pass);
  restrictTo(covered, pass);
  addCompute(f, std::move(pass), [=, frame = f.constants](graph::Context& context) {
    PackSurfacesPush push{.frame = frame, .covered = coveredAddress(covered, context), .slots = {}};
    setSlots(places, context, push.slots);
    return push;
  });
}

}  // namespace

std::vector<ResultTarget> packInSlots(const SurfaceOutputs& outputs, size_t first, bool filled, ComputePass& pass) {
  const std::span some = std::span(outputs.places).subspan(first);
  const std::vector<ResultTarget> places(some.begin(),
                                         some.begin() + std::min<ptrdiff_t>(kPackedAtOnce, std::ssize(some)));
  for (size_t i = 0; i < places.size(); ++i) {
    pass.constants.push_back({outputConstant(i), outputs.bits[first + i]});
    pass.buffers.emplace_back(places[i].buffer, filled ? graph::Use::StorageReadWrite : places[i].use);
  }
  return places;
}

void setSlots(std::span<const ResultTarget> places, graph::Context& context, OutputSlot* slots) {
  for (size_t i = 0; i < places.size(); ++i) slots[i] = {places[i].address(context), places[i].viewBytes};
}

void addBackgrounds(const FrameContext& f, const VisibilityBuffer& visible, const SurfaceOutputs& outputs) {
  if (fillsBackgrounds(f, outputs)) return;
  for (size_t first = 0; first < outputs.places.size(); first += kPackedAtOnce)
    addPack(f, visible, outputs, first, {}, {}, {});
}

std::vector<uint32_t> dataWordsOf(const SurfaceOutputs& outputs) {
  std::set<uint32_t> required;
  for (const uint32_t bits : outputs.bits) {
    const SurfaceOutput output = surfaceOutputOf(bits);
    if (isDepth(output)) continue;
    const bool split = output.second != kPackOneTarget;
    for (uint32_t i = 0; i < (split ? 1 : output.channels); ++i) required.insert(4 * output.target + output.first + i);
    if (split) required.insert(4 * output.second + output.secondFirst);
  }
  std::vector<uint32_t> words;
  for (uint32_t i = 0; const uint32_t word : required) {
    if (i % 4 == 0) words.push_back(kNoDataWords);
    const uint32_t shift = 8 * (i++ % 4);
    words.back() = (words.back() & ~(kNoDataWord << shift)) | word << shift;
  }
  return words;
}

void addDataWords(std::span<const uint32_t> words, std::vector<vk::Constant>& constants) {
  for (uint32_t i = 0; i < words.size(); ++i) constants.push_back({dataWordsConstant(i), words[i]});
}

void addPackedSurfaces(const FrameContext& f, const VisibilityBuffer& visible, const SurfaceOutputs& outputs,
                       std::span<const uint32_t> words, std::span<const graph::ImageId> images) {
  const bool filled = visible.covered && fillsBackgrounds(f, outputs);
  const graph::BufferId covered = filled ? visible.covered : graph::BufferId{};
  for (size_t first = 0; first < outputs.places.size(); first += kPackedAtOnce)
    addPack(f, visible, outputs, first, words, images, covered);
}

}  // namespace latelight::render
