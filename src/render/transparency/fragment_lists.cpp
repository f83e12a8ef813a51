// Order-independent transparency with per-pixel lists (an A-buffer; Carpenter 1984, The A-buffer, an Antialiased Hidden
// Surface Method, SIGGRAPH): all fragments of a pixel are stored, sorted and blended, for any number of surfaces, even
// interpenetrating ones. This is the method `exact`. If the raster is compute, the other methods use the lists too:
// `sorted` with a different order, and `weighted` with a mean.
//
//   raster --fragments, counts--> place --starts--> gather --lists--> sort (long lists) --sorted--> blend
//
// place allocates each pixel's part of the arrays, gather makes the fragments of a pixel contiguous, sort is a merge
// sort over all long lists, and blend composites each pixel over the picture; short lists are sorted there. The raster
// hardware stores shaded fragments; the raster compute shades them after gather (lightFragments()).
//
// If the number of fragments or the longest list exceeds the capacity with which the frame was recorded, nothing is
// blended. A check of the totals detects this and increases the capacity, and the frame is rendered again.
#include <algorithm>
#include <array>
#include <bit>

#include "base/error.h"
#include "render/base/readback.h"
#include "render/transparency/fragments_push.h"
#include "render/transparency/transparency.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

namespace {

using shared::kFragmentRow;
using shared::kShortList;

constexpr uint32_t kGroup = 256;             // invocations of the shaders that loop over fragments
constexpr uint32_t kMaxGroups = 4096;        // maximum workgroups per pass; their invocations loop
constexpr uint32_t kBlendedAtOnce = 16'384;  // fragments of a long list; far below lavapipe's loop limit
constexpr uint64_t kMinFragments = 1 << 16;  // minimum capacity in fragments
constexpr uint64_t kMaxFragments =
    (uint64_t{1} << 31) - 1;  // maximum capacity: indices into buffers are signed in SPIR-V

// The maximum capacity in fragments, which are stored in one buffer.
uint64_t maxFragments(vk::Device& device, const TransparencySetup& setup) {
  const uint64_t most = std::min(kMaxFragments, device.maxBufferSize() / sizeof(shared::Fragment));
  return setup.most ? std::min(most, setup.most) : most;
}

// The capacities with which a frame is recorded.
struct FragmentCapacity {
  uint64_t fragments;
  uint32_t longest;  // length of the longest list, a power of two
};

FragmentCapacity capacityFor(const FrameContext& f) {
  const uint64_t most = maxFragments(f.device, f.setup.transparency);
  const uint64_t first = std::max(uint64_t{f.width} * f.height * f.viewCount(), kMinFragments);
  const uint64_t learned = f.overflow ? f.overflow->fragments : 0;
  return {std::min(learned ? learned : first, most), std::max(f.overflow ? f.overflow->longestList : 0, kShortList)};
}

struct Buffers : FragmentBuffers {
  std::array<graph::BufferId, 2> sorted;  // null if no list can be long
  uint32_t pixels;
  FragmentCapacity limits;
};

Buffers createBuffers(const FrameContext& f, FragmentCapacity limits) {
  Buffers b;
  b.pixels = f.width * f.height * f.viewCount();
  b.limits = limits;
  b.capacity = static_cast<uint32_t>(limits.fragments);
  b.longest = limits.longest;
  const auto make = [&](const char* name, uint64_t bytes) {
    return f.graph.create(vk::BufferDesc{.size = bytes, .name = name});
  };
  b.fragments = make("blended fragments", limits.fragments * sizeof(shared::Fragment));
  b.counts = make("fragments per pixel", uint64_t{4} * b.pixels);
  b.starts = make("starts of lists", uint64_t{4} * b.pixels);
  b.totals = make("totals of fragments", sizeof(shared::FragmentTotals));
  b.lists = make("lists of fragments", 4 * limits.fragments);
  if (limits.longest > kShortList)
    b.sorted = {make("sorted lists", 4 * limits.fragments), make("sorted lists too", 4 * limits.fragments)};
  return b;
}

// A pass over all fragments with the given number of invocations, limited to kMaxGroups workgroups.
ComputePass step(const FrameContext& f, const char* name, const char* shader, uint64_t invocations) {
  constexpr uint64_t kMax = uint64_t{kMaxGroups} * kGroup;
  return {.stage = graph::Stage::Transparency,
          .name = name,
          .shader = shader,
          .bindings = Bindings(f.device),
          .size = {static_cast<uint32_t>(std::min(invocations, kMax)), 1, 1},
          .groupX = kGroup,
          .groupY = 1};
}

void addPlace(const FrameContext& f, const Buffers& b) {
  ComputePass place = step(f, "transparency place", "fragments_place.comp", kFragmentRow);
  place.size = {std::min(b.pixels, kFragmentRow), (b.pixels + kFragmentRow - 1) / kFragmentRow, 1};
  place.buffers = {{b.counts, graph::Use::StorageRead},
                   {b.totals, graph::Use::StorageReadWrite},
                   {b.starts, graph::Use::StorageWrite}};
  addCompute(f, std::move(place), [=](graph::Context& context) {
    return shared::ScatterPush{listsOf(context, b), b.pixels, 0};
  });
  ComputePass gather = step(f, "transparency gather", "fragments_gather.comp", b.limits.fragments);
  gather.buffers = {{b.fragments, graph::Use::StorageRead},
                    {b.starts, graph::Use::StorageRead},
                    {b.totals, graph::Use::StorageRead},
                    {b.lists, graph::Use::StorageWrite}};
  addCompute(f, std::move(gather), [=](graph::Context& context) { return shared::GatherPush{listsOf(context, b)}; });
}

std::vector<graph::Access> readLists(const Buffers& b, graph::BufferId sorted) {
  std::vector<graph::Access> accesses;
  for (graph::BufferId read : {b.fragments, b.counts, b.starts, b.totals, b.lists})
    accesses.emplace_back(read, graph::Use::StorageRead);
  if (sorted != b.lists) accesses.emplace_back(sorted, graph::Use::StorageRead);
  return accesses;
}

// Adds the passes of the merge sort and returns the buffer with the sorted long lists.
graph::BufferId addSort(const FrameContext& f, const Buffers& b) {
  graph::BufferId from = b.lists;
  size_t steps = 0;
  const auto addStep = [&](uint32_t run) {
    const graph::BufferId source = from, target = b.sorted[steps++ % 2];
    ComputePass sort = step(f, "transparency sort", "fragments_sort.comp", b.limits.fragments);
    sort.buffers = readLists(b, source);
    sort.buffers.emplace_back(target, graph::Use::StorageWrite);
    addCompute(f, std::move(sort), [=](graph::Context& context) {
      return shared::SortPush{listsOf(context, b), context.buffer(source).address(), context.buffer(target).address(),
                              run, 0};
    });
    from = target;
  };
  if (b.limits.longest > kShortList) addStep(0);
  for (uint32_t run = kShortList; run < b.limits.longest; run *= 2) addStep(run);
  return from;
}

bool isWeighted(const FrameContext& f) {
  return f.setup.transparency.method == kTransparencyWeighted;
}

// Lists longer than kBlendedAtOnce are blended in parts, one pass each. With `weighted`, which requires complete lists,
// each part then has its own mean.
void addBlend(const FrameContext& f, graph::ImageId light, const Buffers& b, graph::BufferId sorted) {
  for (uint32_t first = 0; first < b.limits.longest; first += kBlendedAtOnce) {
    Bindings bindings(f.device);
    bindings.storage(light, graph::Use::StorageReadWrite);
    addCompute(f,
               {.stage = graph::Stage::Transparency,
                .name = "transparency blend",
                .shader = "fragments_blend.comp",
                .bindings = std::move(bindings),
                .size = f.pixels(),
                .constants = {{kSamplesConstant, fragmentSamples(f.device, f.setup)},
                              {kWeightedConstant, isWeighted(f) ? 1u : 0u}},
                .buffers = readLists(b, sorted)},
               [=](graph::Context& context) {
                 return shared::BlendPush{listsOf(context, b), context.buffer(sorted).address(), first, kBlendedAtOnce,
                                          f.constants};
               });
  }
}

// Returns true if a capacity was exceeded. Increases the capacity, with a margin because the next frame may require
// more.
bool overflowed(const FrameContext& f, FragmentCapacity limits, const shared::FragmentTotals& totals) {
  const uint64_t needed = uint64_t{totals.carries} << 32 | totals.placed;
  if (needed <= limits.fragments && totals.longest <= limits.longest) return false;
  const uint64_t most = maxFragments(f.device, f.setup.transparency);
  if (needed > most)
    fail(ExitCode::OutOfMemory,
         "transparency needs {} fragments of {} bytes for this image, but {} supports at most {}: use a smaller image, "
         "or sorted or weighted with the raster hardware",
         needed, sizeof(shared::Fragment), f.device.info().name, most);
  if (needed > limits.fragments) f.overflow->fragments = std::min(needed + needed / 4, most);
  f.overflow->longestList = std::max(limits.longest, std::bit_ceil(totals.longest));
  return true;
}

void addCheck(const FrameContext& f, const Buffers& b) {
  const graph::BufferId host = copyToHost(f, graph::Stage::Transparency, "transparency totals", {b.totals}).front();
  if (f.overflow)
    f.overflow->checks.push_back([f, host, limits = b.limits](const graph::Submission& done) {
      return overflowed(f, limits, *done.buffer(host).as<shared::FragmentTotals>());
    });
}

}  // namespace

shared::FragmentLists listsOf(graph::Context& context, const FragmentBuffers& b) {
  const auto address = [&](graph::BufferId buffer) {
    return context.declares(buffer) ? context.buffer(buffer).address() : VkDeviceAddress{0};
  };
  return {.fragments = address(b.fragments),
          .counts = address(b.counts),
          .starts = address(b.starts),
          .totals = address(b.totals),
          .lists = address(b.lists),
          .capacity = b.capacity,
          .longest = b.longest};
}

// With the graphics pipeline of lavapipe, fragments with coverage require 17 times as much time as fragments without.
uint32_t fragmentSamples(const vk::Device& device, const FrameConfig& setup) {
  if (setup.sampleLayers) return setup.samples;
  return device.has(VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME) && !device.isCpu() ? setup.samples : 1;
}

void addFragmentLists(const FrameContext& f, const Gbuffer& gbuffer) {
  const Buffers b = createBuffers(f, capacityFor(f));
  addClear(f, graph::Stage::Transparency, "transparency clear", {b.counts, b.totals});
  addFragments(f, gbuffer, b);
  addPlace(f, b);
  lightFragments(f, gbuffer, b);
  addBlend(f, gbuffer.light, b, addSort(f, b));
  addCheck(f, b);
}

}  // namespace latelight::render
