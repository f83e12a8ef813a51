// exact: every fragment is kept, sorted in its pixel, and blended: any number of layers, interpenetrating ones too.
//
// Where the fragments, or the longest list, are more than the frame was recorded for, nothing is blended; outgrown()
// finds it in the totals and makes room, and the frame is done again.
#include <algorithm>
#include <array>
#include <bit>

#include "base/error.h"
#include "render/lit_maps.h"
#include "render/transparency/methods.h"
#include "render/visibility/hardware.h"
#include "shared/fragment_lists.h"

namespace latelight::render {

namespace {

using shared::kShortList;

struct StorePush {  // varyings.glsl with DRAW_PUSH_FRAGMENTS
  VkDeviceAddress frame;
  uint32_t view;
  shared::FragmentLists lists;
  shared::DrawOrder order;
};
struct PlacePush {  // fragments_place.comp
  shared::FragmentLists lists;
  uint32_t pixels;
};
struct SortPush {  // fragments_sort.comp
  shared::FragmentLists lists;
  VkDeviceAddress from, to;
  uint32_t run;
};
struct BlendPush {  // fragments_blend.comp
  shared::FragmentLists lists;
  VkDeviceAddress sorted;
  uint32_t first, count;
};

constexpr uint32_t kGroup = 256;                         // invocations of the shaders that go over fragments
constexpr uint32_t kMostGroups = 4096;                   // of them in flight; each takes its share
constexpr uint32_t kBlendedAtOnce = 16'384;              // of a long list: far from lavapipe's limit on loops
constexpr uint64_t kLeastRoom = 1 << 16;                 // fragments
constexpr uint64_t kMostRoom = (uint64_t{1} << 31) - 1;  // indices into buffers are signed in SPIR-V

vk::Pipeline makeStep(vk::Device& device, const char* shader, std::vector<vk::Binding> bindings = {},
                      std::vector<vk::Constant> constants = {}) {
  return vk::makePipeline(
      device,
      vk::ComputeDesc{
          .shader = shader, .bindings = std::move(bindings), .constants = std::move(constants), .name = shader});
}

void requireStores(vk::Device& device) {
  VkPhysicalDeviceFeatures features;
  vkGetPhysicalDeviceFeatures(device.physical(), &features);
  if (!features.fragmentStoresAndAtomics)
    fail(ExitCode::NoDevice,
         "{} can't write to memory from fragment shaders, which exact transparency takes: choose sorted or weighted",
         device.info().name);
}

// The hard bound: fragments lie in one buffer.
uint64_t mostRoom(vk::Device& device, const TransparencySetup& setup) {
  const uint64_t most = std::min(kMostRoom, device.maxBufferSize() / sizeof(shared::Fragment));
  return setup.most ? std::min(most, setup.most) : most;
}

// Those of the frame where a fragment can tell which of them the depth test has left; else depth is that of pixels. Not
// on lavapipe, which takes 17 times as long for the same fragments then.
uint32_t samplesOf(const vk::Device& device, const FrameSetup& setup) {
  return device.has(VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME) && !device.isCpu() ? setup.samples : 1;
}

class Exact final : public Transparency {
 public:
  Exact(vk::Device& device, const GpuScene& scene, const FrameSetup& setup)
      : device_(device),
        samples_(samplesOf(device, setup)),
        most_(mostRoom(device, setup.transparency)),
        room_{setup.transparency.fragments, kShortList} {
    requireStores(device);
    store_ = makeBlendedPipeline(device, scene, setup,
                                 {.fragment = shaderVariant("blended_store.frag", samples_), .samples = samples_});
    place_ = makeStep(device, "fragments_place.comp");
    gather_ = makeStep(device, "fragments_gather.comp");
    sort_ = makeStep(device, "fragments_sort.comp");
    blend_ = makeStep(device, "fragments_blend.comp", {vk::Binding::Storage}, {{kFirstOwnConstant, samples_}});
  }

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) override;
  bool outgrown(const graph::Executor& done) override;

 private:
  struct Room {
    uint64_t fragments;
    uint32_t longest;  // list; a power of two
  };
  struct Buffers {
    graph::BufferId fragments, counts, starts, totals, lists;
    std::array<graph::BufferId, 2> sorted;  // only where lists may be long
    uint32_t pixels;
    Room room;
  };
  using Draws = std::vector<std::vector<Draw>>;

  Buffers create(graph::Graph& graph, const FrameInputs& inputs) const;
  static shared::FragmentLists listsOf(graph::Context& context, const Buffers& b);
  static void addClear(graph::Graph& graph, const Buffers& b);
  void addStore(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer, const Buffers& b,
                const Draws& draws) const;
  void addPlace(graph::Graph& graph, const Buffers& b) const;
  graph::BufferId addSort(graph::Graph& graph, const Buffers& b) const;
  void addBlend(graph::Graph& graph, graph::ImageId light, const Buffers& b, graph::BufferId sorted) const;
  static graph::BufferId addReadback(graph::Graph& graph, const Buffers& b);
  static void dispatchOverFragments(graph::Context& context, const Buffers& b) {
    const uint64_t groups = (b.room.fragments + kGroup - 1) / kGroup;
    vkCmdDispatch(context.get(), static_cast<uint32_t>(std::min<uint64_t>(groups, kMostGroups)), 1, 1);
  }

  vk::Device& device_;
  uint32_t samples_;  // a pixel
  uint64_t most_;     // fragments
  vk::Pipeline store_, place_, gather_, sort_, blend_;
  Room room_;
  graph::BufferId totals_;  // on the host, of the graph filled last; none where it has nothing blended
};

Exact::Buffers Exact::create(graph::Graph& graph, const FrameInputs& inputs) const {
  Buffers b;
  b.pixels = inputs.width * inputs.height * static_cast<uint32_t>(inputs.views.size());
  b.room = room_;
  const auto make = [&](const char* name, uint64_t bytes) {
    return graph.create(vk::BufferDesc{.size = bytes, .name = name});
  };
  b.fragments = make("blended fragments", room_.fragments * sizeof(shared::Fragment));
  b.counts = make("fragments a pixel", uint64_t{4} * b.pixels);
  b.starts = make("starts of lists", uint64_t{4} * b.pixels);
  b.totals = make("totals of fragments", sizeof(shared::FragmentTotals));
  b.lists = make("lists of fragments", 4 * room_.fragments);
  if (room_.longest > kShortList)
    b.sorted = {make("sorted lists", 4 * room_.fragments), make("sorted lists too", 4 * room_.fragments)};
  return b;
}

// With the buffers that the running pass declares.
shared::FragmentLists Exact::listsOf(graph::Context& context, const Buffers& b) {
  const auto address = [&](graph::BufferId buffer) {
    return context.declares(buffer) ? context.buffer(buffer).address() : VkDeviceAddress{0};
  };
  return {.fragments = address(b.fragments),
          .counts = address(b.counts),
          .starts = address(b.starts),
          .totals = address(b.totals),
          .lists = address(b.lists),
          .capacity = static_cast<uint32_t>(b.room.fragments),
          .longest = b.room.longest};
}

void Exact::addClear(graph::Graph& graph, const Buffers& b) {
  graph.pass(graph::Stage::Transparency, "transparency clear",
             {{b.counts, graph::Use::CopyTarget}, {b.totals, graph::Use::CopyTarget}}, [=](graph::Context& context) {
               for (graph::BufferId buffer : {b.counts, b.totals})
                 vkCmdFillBuffer(context.get(), context.buffer(buffer).get(), 0, VK_WHOLE_SIZE, 0);
             });
}

void Exact::addStore(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer, const Buffers& b,
                     const Draws& draws) const {
  const graph::ImageId depth = samples_ > 1 ? gbuffer.sampleDepth : gbuffer.depth;
  std::vector<graph::Access> accesses{{depth, graph::Use::DepthTest},
                                      {b.fragments, graph::Use::FragmentWrite},
                                      {b.counts, graph::Use::FragmentReadWrite},
                                      {b.totals, graph::Use::FragmentReadWrite}};
  appendLitAccesses(accesses, gbuffer, graph::Use::SampledFragment);
  graph.pass(graph::Stage::Transparency, "transparency store", std::move(accesses), [=, this](graph::Context& context) {
    std::vector<vk::BoundImage> images;
    appendLitImages(images, context, inputs, gbuffer);
    const shared::FragmentLists lists = listsOf(context, b);
    for (uint32_t view = 0; view < inputs.views.size(); ++view) {
      beginView(context, inputs, view, {}, {depth, false});
      SceneBinder binder(context, inputs, view, store_, store_, images);
      uint32_t order = 0;  // beyond 2^32 triangles in a view it starts again
      for (const Draw& draw : draws[view]) {
        binder.bind(draw);
        const uint32_t triangles = draw.indexCount / 3;
        context.commands().push(store_,
                                StorePush{inputs.constants, view, lists, {order, draw.firstInstance, triangles}});
        drawRun(context, draw);
        order += triangles * draw.instanceCount;
      }
      vkCmdEndRendering(context.get());
    }
  });
}

void Exact::addPlace(graph::Graph& graph, const Buffers& b) const {
  constexpr uint32_t kRow = 65536;  // fragments_place.comp
  graph.pass(graph::Stage::Transparency, "transparency place",
             {{b.counts, graph::Use::StorageRead},
              {b.totals, graph::Use::StorageReadWrite},
              {b.starts, graph::Use::StorageWrite}},
             [=, this](graph::Context& context) {
               context.commands().bind(place_, {}, PlacePush{listsOf(context, b), b.pixels});
               context.commands().dispatch(std::min(b.pixels, kRow), (b.pixels + kRow - 1) / kRow, 1, kGroup, 1);
             });
  graph.pass(graph::Stage::Transparency, "transparency gather",
             {{b.fragments, graph::Use::StorageRead},
              {b.starts, graph::Use::StorageRead},
              {b.totals, graph::Use::StorageRead},
              {b.lists, graph::Use::StorageWrite}},
             [=, this](graph::Context& context) {
               context.commands().bind(gather_, {}, listsOf(context, b));
               dispatchOverFragments(context, b);
             });
}

// The array that has the long lists in order.
graph::BufferId Exact::addSort(graph::Graph& graph, const Buffers& b) const {
  graph::BufferId from = b.lists;
  size_t steps = 0;
  const auto addStep = [&](uint32_t run) {
    const graph::BufferId source = from, target = b.sorted[steps++ % 2];
    std::vector<graph::Access> accesses{{target, graph::Use::StorageWrite}};
    for (graph::BufferId read : {b.fragments, b.counts, b.starts, b.totals, b.lists})
      accesses.emplace_back(read, graph::Use::StorageRead);
    if (source != b.lists) accesses.emplace_back(source, graph::Use::StorageRead);
    graph.pass(
        graph::Stage::Transparency, "transparency sort", std::move(accesses), [=, this](graph::Context& context) {
          context.commands().bind(
              sort_, {},
              SortPush{listsOf(context, b), context.buffer(source).address(), context.buffer(target).address(), run});
          dispatchOverFragments(context, b);
        });
    from = target;
  };
  if (b.room.longest > kShortList) addStep(0);
  for (uint32_t run = kShortList; run < b.room.longest; run *= 2) addStep(run);
  return from;
}

void Exact::addBlend(graph::Graph& graph, graph::ImageId light, const Buffers& b, graph::BufferId sorted) const {
  const vk::ImageDesc desc = graph.desc(light);
  for (uint32_t first = 0; first < b.room.longest; first += kBlendedAtOnce) {
    std::vector<graph::Access> accesses{{light, graph::Use::StorageReadWrite}};
    for (graph::BufferId read : {b.fragments, b.counts, b.starts, b.totals, b.lists})
      accesses.emplace_back(read, graph::Use::StorageRead);
    if (sorted != b.lists) accesses.emplace_back(sorted, graph::Use::StorageRead);
    graph.pass(graph::Stage::Transparency, "transparency blend", std::move(accesses),
               [=, this](graph::Context& context) {
                 context.commands().bind(
                     blend_, {{context.image(light).arrayView()}},
                     BlendPush{listsOf(context, b), context.buffer(sorted).address(), first, kBlendedAtOnce});
                 context.commands().dispatch(desc.width, desc.height, desc.layers, 16, 16);
               });
  }
}

graph::BufferId Exact::addReadback(graph::Graph& graph, const Buffers& b) {
  const graph::BufferId host = graph.create(vk::BufferDesc{
      .size = sizeof(shared::FragmentTotals), .kind = vk::MemoryKind::Readback, .name = "totals of fragments, host"});
  graph.pass(graph::Stage::Transparency, "transparency totals",
             {{b.totals, graph::Use::CopySource}, {host, graph::Use::CopyTarget}}, [=](graph::Context& context) {
               const VkBufferCopy region{0, 0, sizeof(shared::FragmentTotals)};
               vkCmdCopyBuffer(context.get(), context.buffer(b.totals).get(), context.buffer(host).get(), 1, &region);
             });
  graph.exports(host, graph::Use::HostRead);
  return host;
}

void Exact::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) {
  totals_ = {};
  const Draws draws = blendedDraws(inputs);
  if (!anyDraw(draws)) return;
  if (room_.fragments == 0)
    room_.fragments =
        std::min(std::max(uint64_t{inputs.width} * inputs.height * inputs.views.size(), kLeastRoom), most_);
  const Buffers b = create(graph, inputs);
  addClear(graph, b);
  addStore(graph, inputs, gbuffer, b, draws);
  addPlace(graph, b);
  addBlend(graph, gbuffer.light, b, addSort(graph, b));
  totals_ = addReadback(graph, b);
}

bool Exact::outgrown(const graph::Executor& done) {
  if (!totals_) return false;
  const shared::FragmentTotals totals = *done.buffer(totals_).as<shared::FragmentTotals>();
  const uint64_t needed = uint64_t{totals.carries} << 32 | totals.placed;
  if (needed <= room_.fragments && totals.longest <= room_.longest) return false;
  if (needed > most_)
    fail(ExitCode::DeviceLost,
         "exact transparency has {} fragments of {} bytes to keep in this picture, and {} takes {} at most: choose "
         "sorted or weighted, or a smaller picture",
         needed, sizeof(shared::Fragment), device_.info().name, most_);
  // Some more than needed: the next frame may see more.
  if (needed > room_.fragments) room_.fragments = std::min(needed + needed / 4, most_);
  room_.longest = std::max(room_.longest, std::bit_ceil(totals.longest));
  return true;
}

}  // namespace

std::unique_ptr<Transparency> makeExactTransparency(vk::Device& device, const GpuScene& scene,
                                                    const FrameSetup& setup) {
  return std::make_unique<Exact>(device, scene, setup);
}

}  // namespace latelight::render
