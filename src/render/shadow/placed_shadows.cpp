#include "render/shadow/placed_shadows.h"

#include <algorithm>
#include <cstring>

#include "render/shadow/atlas.h"
#include "render/shadow/cascades.h"
#include "render/shadow/page_push.h"
#include "render/visibility/compute/raster_push.h"

namespace latelight::render {

namespace {

using namespace shared;

static_assert(kMaxCascades == kCascades && kMinPlacedTile == kMinShadowTile);

// The size of the visibility buffer in which maps are rasterized. Each filling of it is a chain of dispatches.
constexpr uint64_t kTexelsAtOnce = uint64_t{1} << 26;
constexpr uint32_t kMaxLayerSide = 8192;  // texels of a layer of the atlas

// Offsets of lists in a buffer, in the order in which they are added.
class Offsets {
 public:
  uint64_t add(uint64_t bytes) {
    const uint64_t offset = total_;
    total_ += (bytes + 15) / 16 * 16;
    return offset;
  }
  uint64_t total() const { return total_; }

 private:
  uint64_t total_ = 0;
};

// Copies lists to mapped memory, one after the other, and returns their addresses.
class JobWriter {
 public:
  explicit JobWriter(const vk::Buffer& buffer) : buffer_(buffer) { offsets_.add(sizeof(PlacedShadowJob)); }
  template <typename T>
  VkDeviceAddress add(std::span<const T> values) {
    const uint64_t offset = offsets_.add(values.size_bytes());
    std::memcpy(buffer_.mapped() + offset, values.data(), values.size_bytes());
    return buffer_.address() + offset;
  }

 private:
  const vk::Buffer& buffer_;
  Offsets offsets_;
};

uint64_t jobBytes(const PlacedShadowPlan& plan) {
  Offsets offsets;
  offsets.add(sizeof(PlacedShadowJob));
  offsets.add(plan.lights.size() * sizeof(ShadowBits));
  offsets.add(plan.suns.size() * sizeof(MapTemplate));
  offsets.add(plan.axes.size() * sizeof(double));
  offsets.add(plan.locals.size() * sizeof(LocalCaster));
  offsets.add(plan.faces.size() * sizeof(MapTemplate));
  offsets.add(plan.tangents.size() * sizeof(double));
  offsets.add((1 + plan.sizes) * sizeof(PlacedMaps));
  offsets.add((kMaxCascades + 2 * plan.depths.size()) * sizeof(double));
  return offsets.total();
}

// The side of a layer of the atlas, in texels, for maps of at most this size.
uint32_t sideOf(uint32_t size, uint64_t maps) {
  const uint64_t texels = maps * size * size;
  uint32_t side = size;
  while (side < kMaxLayerSide && uint64_t{side} * side < texels) side *= 2;
  return side;
}

}  // namespace

PlacedShadows::PlacedShadows(vk::Device& device, const PlacedShadowPlan& plan, uint32_t views, uint64_t mostMaps)
    : device_(device),
      views_(views),
      lights_(static_cast<uint32_t>(plan.suns.size() + plan.locals.size())),
      side_(sideOf(plan.size, views * (plan.suns.size() * kMaxCascades + plan.localMaps))) {
  addGroup(views * static_cast<uint32_t>(plan.suns.size()) * kMaxCascades, plan.size, mostMaps);
  for (uint32_t i = 0; i < plan.sizes; ++i) addGroup(views * plan.localMaps, kMinPlacedTile << i, mostMaps);
  Offsets offsets;
  table_ = offsets.add(uint64_t{views} * lights_ * sizeof(LightShadow));
  shadowMaps_ = offsets.add(maps_ * sizeof(ShadowMap));
  mapViews_ = offsets.add(maps_ * sizeof(View));
  mapFrames_ = offsets.add(maps_ * sizeof(shared::FrameConstants));
  targets_ = offsets.add(maps_ * sizeof(ShadowTarget));
  within_ = offsets.add(maps_ * sizeof(RasterMap));
  results_ = vk::Buffer(device, {.size = offsets.total(), .name = "shadow maps of worlds"});
  pages_ = vk::Buffer(device, {.size = rows_ * sizeof(uint32_t),
                               .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                               .name = "shadow pages of worlds"});
}

void PlacedShadows::addGroup(uint32_t count, uint32_t size, uint64_t mostMaps) {
  const uint64_t atOnce = std::min({kTexelsAtOnce / (uint64_t{size} * size), mostMaps, uint64_t{count}});
  const PlacedMaps group{.first = maps_,
                         .count = count,
                         .size = size,
                         .rows = (size + kShadowPage - 1) / kShadowPage,
                         .mapsAtOnce = static_cast<uint32_t>(std::max<uint64_t>(atOnce, 1)),
                         .across = side_ / size,
                         .firstLayer = layers_,
                         .firstRow = rows_};
  groups_.push_back(group);
  maps_ += count;
  layers_ += (count + group.across * group.across - 1) / (group.across * group.across);
  rows_ += count * group.rows;
}

void PlacedShadows::update(const PlacedShadowPlan& plan, const Inputs& inputs) {
  if (!job_)
    job_ = vk::Buffer(device_, {.size = jobBytes(plan),
                                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                .kind = vk::MemoryKind::Upload,
                                .name = "shadow maps of worlds, common values"});
  JobWriter writer(job_);
  const VkDeviceAddress bits = writer.add(std::span(plan.lights));
  shadowBits_ = inputs.casters ? inputs.shadowBits : bits;
  PlacedShadowJob job{.suns = writer.add(std::span(plan.suns)),
                      .axes = writer.add(std::span(plan.axes)),
                      .locals = writer.add(std::span(plan.locals)),
                      .faces = writer.add(std::span(plan.faces)),
                      .tangents = writer.add(std::span(plan.tangents)),
                      .groups = writer.add(std::span<const PlacedMaps>(groups_))};
  std::vector<double> numbers;
  for (uint32_t i = 0; i < kCascades; ++i) numbers.push_back(cascadeShare(i));
  for (const glm::dvec2& depth : plan.depths) numbers.insert(numbers.end(), {depth.x, depth.y});
  job.numbers = writer.add(std::span<const double>(numbers));
  job.casters = inputs.casters;
  job.bounds = inputs.bounds;
  job.views = inputs.views;
  job.frames = inputs.frames;
  job.table = at(table_, 0);
  job.maps = at(shadowMaps_, 0);
  job.mapViews = at(mapViews_, 0);
  job.mapFrames = at(mapFrames_, 0);
  job.targets = at(targets_, 0);
  job.within = at(within_, 0);
  job.pages = pages_.address();
  job.sunCount = static_cast<uint32_t>(plan.suns.size());
  job.localCount = static_cast<uint32_t>(plan.locals.size());
  job.localMaps = plan.localMaps;
  job.sizes = plan.sizes;
  job.viewCount = views_;
  job.firstView = inputs.firstView;
  job.viewsPerWorld = static_cast<uint32_t>(plan.depths.size());
  *job_.as<PlacedShadowJob>() = job;
}

void PlacedShadows::addTo(graph::Graph& graph) const {
  const vk::PipelineRef pipeline = device_.cache().pipeline(
      vk::ComputeDesc{.shader = "place_shadows.comp", .pushBytes = sizeof(PlaceShadowsPush), .name = "place shadows"});
  graph.prologue(graph::Stage::Upload, "place shadows", [=, job = job_.address(), views = views_](graph::Context& c) {
    c.commands().bind(pipeline.get(), {}, PlaceShadowsPush{job});
    vkCmdDispatch(c.get(), (views + kPlaceShadowsGroup - 1) / kPlaceShadowsGroup, 1, 1);
  });
}

void PlacedShadows::describe(shared::FrameConstants& frame) const {
  frame.shadowBits = shadowBits_;
  frame.lightShadows = at(table_, 0);
  frame.shadowMaps = at(shadowMaps_, 0);
  frame.shadowColumns = lights_;
}

vk::ImageDesc PlacedShadows::atlas(VkFormat format) const {
  return {.format = format, .width = side_, .height = side_, .layers = layers_, .name = "shadow atlas of worlds"};
}

VkDeviceAddress PlacedShadows::targets(uint32_t first) const {
  return at(targets_, first * sizeof(ShadowTarget));
}
VkDeviceAddress PlacedShadows::within(uint32_t first) const {
  return at(within_, first * sizeof(RasterMap));
}

}  // namespace latelight::render
