#include "render/submit/cast.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <deque>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "render/base/readback.h"
#include "render/options/options.h"
#include "render/rays/cast_push.h"
#include "render/submit/job.h"
#include "render/submit/renderer.h"
#include "vk/deletion.h"

namespace latelight::render {

namespace {

constexpr size_t kRaysAtOnce = size_t{1} << 18;
constexpr size_t kChunksInFlight = 4;

// An array of hits in the host's memory.
struct HitArray {
  const HitInfo* info;
  size_t bytes;  // per ray
  std::byte* target;
};

// Returns those that are needed.
std::vector<HitArray> arraysOf(const CastTargets& targets) {
  std::vector<HitArray> arrays;
  const auto add = [&](const HitInfo& info, auto* target) {
    if (target) arrays.push_back({&info, sizeof(*target), reinterpret_cast<std::byte*>(target)});
  };
  forEachHitArray(add, targets);
  return arrays;
}

// Memory that the device reads. Calls that are dropped before they have finished defer its release.
struct MemoryInUse final : vk::Deletion {
  explicit MemoryInUse(std::vector<std::shared_ptr<const void>> memory) : memory(std::move(memory)) {}
  std::vector<std::shared_ptr<const void>> memory;
};

// Rays in flight. The arrays of their hits follow one another in `hits`.
struct CastChunk {
  size_t first, count;
  std::unique_ptr<MemoryInUse> rays;
  graph::BufferId hits;  // readable by the host
  graph::Submission submission;

  // Copies the hits of the chunk to all arrays.
  void store(const std::vector<HitArray>& arrays) const {
    const std::byte* from = submission.buffer(hits).as<std::byte>();
    std::vector<MemoryCopy> copies;
    for (const HitArray& array : arrays) {
      copies.push_back({array.target + first * array.bytes, from, count * array.bytes});
      from += count * array.bytes;
    }
    copyInParallel(copies);
  }
};

// The rays of the caller: arrays of doubles or floats, with as many origins as directions.
struct RayArrays {
  const std::byte *origins, *directions;
  size_t count, bytes;  // bytes: of one origin or direction
};

// Throws Error(Usage) if the rays are not valid.
RayArrays arraysOf(const CastRays& rays) {
  const bool floats = !rays.floatOrigins.empty() || !rays.floatDirections.empty();
  const size_t origins = floats ? rays.floatOrigins.size() : rays.origins.size(),
               directions = floats ? rays.floatDirections.size() : rays.directions.size();
  if (origins != directions) badUsage("{} rays have an origin, but {} have a direction", origins, directions);
  const auto bytes = [](const auto& vectors) { return std::as_bytes(vectors).data(); };
  if (floats) return {bytes(rays.floatOrigins), bytes(rays.floatDirections), origins, sizeof(glm::vec3)};
  return {bytes(rays.origins), bytes(rays.directions), origins, sizeof(glm::dvec3)};
}

// The values that all chunks of a call have in common.
struct CastCall {
  const shared::FrameConstants& frame;
  RayArrays rays;
  std::array<double, 7> numbers;  // CastPush::numbers
  uint32_t flags;
  std::vector<HitArray> arrays;
  std::vector<vk::Constant> constants;

  size_t bytesPerRay() const {
    size_t bytes = 0;
    for (const HitArray& array : arrays) bytes += array.bytes;
    return bytes;
  }
};

ComputePass castPass(const Builder& b, uint32_t rays, std::vector<vk::Constant> constants) {
  constexpr uint32_t kGroup = 64, kRow = 32768 * kGroup;  // invocations per row of a dispatch
  return {.stage = graph::Stage::Visibility,
          .name = "cast rays",
          .shader = "cast.comp",
          .bindings = Bindings(b.device),
          .size = {std::min(rays, kRow), (rays + kRow - 1) / kRow, 1},
          .constants = std::move(constants),
          .groupX = kGroup,
          .groupY = 1};
}

// Adds the pass that casts the rays of a buffer that the host has written: all origins, then all directions. The device
// reads them over the bus while it traces others. Returns their hits.
graph::BufferId addCast(const Builder& b, const CastCall& call, const vk::Buffer& rays, size_t rayCount,
                        graph::Graph& graph) {
  const graph::BufferId source = graph.import(rays, std::nullopt);
  const graph::BufferId hits = createResult(b, "hits", rayCount * call.bytesPerRay(), 1).buffer;
  const VkDeviceAddress frame = graph.constants(std::as_bytes(std::span(&call.frame, 1)));
  const VkDeviceAddress numbers = graph.constants(std::as_bytes(std::span(call.numbers)));
  const auto count = static_cast<uint32_t>(rayCount);
  ComputePass pass = castPass(b, count, call.constants);
  pass.buffers = {{source, graph::Use::StorageRead}, {hits, graph::Use::StorageWrite}};
  addCompute(b, std::move(pass),
             [=, arrays = call.arrays, flags = call.flags, rayBytes = call.rays.bytes](graph::Context& context) {
               const VkDeviceAddress origins = context.buffer(source).address();
               shared::CastPush push{.frame = frame,
                                     .origins = origins,
                                     .directions = origins + rayCount * rayBytes,
                                     .numbers = numbers,
                                     .count = count,
                                     .flags = flags,
                                     .perWorld = count};
               VkDeviceAddress at = context.buffer(hits).address();
               for (const HitArray& array : arrays) {
                 push.*array.info->address = at;
                 at += rayCount * array.bytes;
               }
               return push;
             });
  return addReadback(b, hits);
}

// Throws Error(Usage) if the settings request values that rays do not have.
void checkRays(const Settings& settings, double maxDistance) {
  checkSettings(settings);
  if (settings.normalFrame != NormalFrame::World)
    badUsage("rays have no camera: their normals require --normal-frame world");
  if (!(maxDistance >= 0)) badUsage("the maximum distance of rays must be at least 0, not {}", maxDistance);
}

std::array<double, 7> numbersOf(const glm::dvec3& origin, const Settings& settings, double maxDistance) {
  const glm::dvec3& positions = settings.positionOrigin.point;
  return {origin.x, origin.y, origin.z, positions.x, positions.y, positions.z, maxDistance};
}

uint32_t flagsOf(const scene::Scene& scene, const Settings& settings, bool doubles) {
  const bool file = scene.yUp && settings.axes == Axes::File;
  return (doubles ? shared::kCastDoubles : 0u) | (file ? shared::kCastFileAxes : 0u) |
         (settings.dataSurfaces == DataSurfaces::Any ? shared::kRayAnySurface : 0u);
}

}  // namespace

std::span<const HitInfo> hitInfos() {
  static constexpr HitInfo kInfos[] = {
#define HIT_ARRAY(name, element, channels) \
  {#name, &shared::CastPush::name, channels, std::is_same_v<element, uint32_t>},
#include "render/rays/hits.def"
  };
  return kInfos;
}

std::vector<WorldCast::Target> worldTargets(const CastTargets& targets) {
  std::vector<WorldCast::Target> all;
  for (const HitArray& array : arraysOf(targets)) all.push_back({array.info, array.target});
  return all;
}

// Brings the worlds of a call to the device.
void Renderer::followWorlds(const SceneState& moment) {
  gpuScene_.setWorlds(moment.worlds, moment.poses, {});
  if (!moment.worlds.inputs) return;
  drawOrder_.update(gpuScene_);
  gpuScene_.storeClusters();
  rasterInstances_.update(gpuScene_, drawOrder_, gpuScene_.uploads());
  worldPlacer_.update(scene_, gpuScene_, rasterInstances_, moment.worlds, moment.poses, gpuScene_.uploads(), 1, 1,
                      false);
}

shared::FrameConstants Renderer::prepareRays(const Settings& settings, const SceneState& moment) {
  discardChanges();
  resolveOverflow();
  sceneInput_.reset();
  createBvh();
  gpuScene_.update(moment.poses, sunOf(settings));
  followWorlds(moment);
  shared::FrameConstants constants{};
  const SceneBvh& bvh = followedBvh(false);
  gpuScene_.describe(constants);
  constants.rayScene = bvh.address();
  return constants;
}

std::vector<vk::Constant> Renderer::rayConstants() const {
  return {{kTextureSlotsConstant, gpuScene_.materials().textureSlots()}};
}

graph::Submission Renderer::traceRays(const AddRayPasses& add, const Settings& settings, const SceneState& moment) {
  const shared::FrameConstants constants = prepareRays(settings, moment);
  graph::Graph graph(executor_);
  add({device_, graph}, {.frame = graph.constants(std::as_bytes(std::span(&constants, 1))),
                         .constants = rayConstants(),
                         .origin = gpuScene_.origin()});
  addSceneChanges(graph);
  graph::Submission done = submit(graph, graph.compile());
  done.wait();
  return done;
}

BvhStatistics Renderer::bvhStatistics() const {
  return bvh_ ? bvh_->statistics() : BvhStatistics{};
}

CastResult Renderer::cast(const CastRays& rays, const Settings& settings, const SceneState& moment) {
  CastResult result;
  HitMemory<CastTargets, CastHits> memory(result.hits, std::max(rays.origins.size(), rays.floatOrigins.size()));
  result.statistics = cast(rays, memory.targets(), settings, moment, [&] { memory.wait(); });
  result.bvhBytes = bvh_->bytes();
  return result;
}

struct CastTicket::Call {
  explicit Call(vk::Device& device) : device(device) {}
  ~Call() {
    for (CastChunk& chunk : inFlight) device.deferDeletion(std::move(chunk.rays));
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  vk::Device& device;
  std::vector<HitArray> arrays;
  std::function<void()> beforeStore;
  std::deque<CastChunk> inFlight;
  RenderStatistics statistics;

  void prepareStore() {
    if (const std::function<void()> prepare = std::exchange(beforeStore, {})) prepare();
  }
  void finishFirst() {
    inFlight.front().submission.wait();
    const CastChunk chunk = std::move(inFlight.front());
    inFlight.pop_front();
    prepareStore();
    chunk.store(arrays);
    addTimes(statistics.passTimes, chunk.submission);
  }
};

CastTicket::CastTicket(std::unique_ptr<Call> call) : call_(std::move(call)) {}
CastTicket::CastTicket(CastTicket&&) noexcept = default;
CastTicket& CastTicket::operator=(CastTicket&&) noexcept = default;
CastTicket::~CastTicket() = default;

bool CastTicket::done() const {
  return !call_ || std::ranges::all_of(call_->inFlight, [](const CastChunk& c) { return c.submission.done(); });
}

RenderStatistics CastTicket::take() {
  // An exception of Device::whileWaiting() must leave the hits for another call.
  while (!call_->inFlight.empty()) call_->finishFirst();
  const std::unique_ptr<Call> call = std::move(call_);
  call->prepareStore();  // even if there is nothing to store
  return std::move(call->statistics);
}

// The host copies the rays and the hits of some chunks while the device casts those of others.
CastTicket Renderer::submitCast(const CastRays& rays, const CastTargets& targets, const Settings& settings,
                                const SceneState& moment, std::function<void()> beforeStore) {
  checkRays(settings, rays.maxDistance);
  const RayArrays arrays = arraysOf(rays);
  const shared::FrameConstants constants = prepareRays(settings, moment);
  const CastCall call{.frame = constants,
                      .rays = arrays,
                      .numbers = numbersOf(gpuScene_.origin(), settings, rays.maxDistance),
                      .flags = flagsOf(scene_, settings, arrays.bytes == sizeof(glm::dvec3)),
                      .arrays = arraysOf(targets),
                      .constants = rayConstants()};
  auto ticket = std::make_unique<CastTicket::Call>(device_);
  ticket->arrays = call.arrays;
  ticket->beforeStore = std::move(beforeStore);
  const size_t most = std::min(kRaysAtOnce, arrays.count);
  for (size_t first = 0; first < arrays.count; first += most) {
    if (ticket->inFlight.size() == kChunksInFlight) ticket->finishFirst();
    const size_t count = std::min(most, arrays.count - first), offset = first * arrays.bytes,
                 bytes = count * arrays.bytes;
    const auto staging = inputMemory(2 * most * arrays.bytes);
    const MemoryCopy copies[] = {{staging->mapped(), arrays.origins + offset, bytes},
                                 {staging->mapped() + bytes, arrays.directions + offset, bytes}};
    copyInParallel(copies);
    graph::Graph graph(executor_);
    const graph::BufferId hits = addCast({device_, graph}, call, *staging, count, graph);
    addSceneChanges(graph);
    auto memory = std::make_unique<MemoryInUse>(std::vector<std::shared_ptr<const void>>{staging});
    ticket->inFlight.push_back({first, count, std::move(memory), hits, submit(graph, graph.compile())});
  }
  return CastTicket(std::move(ticket));
}

namespace {

uint64_t bytesOf(const WorldCast::Target& hits, uint64_t count) {
  return count * hits.array->channels * sizeof(float);
}

// Adds the pass that casts the rays of all worlds, with its constants except the addresses of hits. Returns the buffers
// that the host reads, in the order of their targets.
std::vector<graph::BufferId> addWorldCast(const Builder& b, ComputePass pass, const shared::CastPush& push,
                                          std::span<const WorldCast::Target> targets) {
  std::vector<std::pair<uint64_t shared::CastPush::*, graph::BufferId>> arrays;
  std::vector<graph::BufferId> needed;
  for (const WorldCast::Target& hits : targets) {
    const graph::BufferId buffer =
        hits.host ? createResult(b, std::string(hits.array->name), bytesOf(hits, push.count), 1).buffer
                  : b.graph.import(hits.memory->buffer, std::nullopt);
    if (hits.host)
      needed.push_back(buffer);
    else
      b.graph.exports(buffer, graph::Use::HostRead);
    pass.buffers.emplace_back(buffer, graph::Use::StorageWrite);
    arrays.emplace_back(hits.array->address, buffer);
  }
  addCompute(b, std::move(pass), [push, arrays = std::move(arrays)](graph::Context& context) {
    shared::CastPush complete = push;
    for (const auto& [address, buffer] : arrays) complete.*address = context.buffer(buffer).address();
    return complete;
  });
  return addReadback(b, needed);
}

}  // namespace

struct WorldCastTicket::Call {
  Call(vk::Device& device, WorldCast&& cast, const WorldStates& worlds)
      : device(device),
        memory(std::make_unique<MemoryInUse>(std::move(cast.memory))),
        hits{.worlds = worlds.count, .rays = cast.rays, .arrays = std::move(cast.hits)} {
    const auto hold = [&](const auto& more) { memory->memory.insert(memory->memory.end(), more.begin(), more.end()); };
    hold(worlds.deformations.memory);
    if (worlds.inputs) hold(worlds.inputs->memory);
  }
  ~Call() {
    if (memory) device.deferDeletion(std::move(memory));
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  vk::Device& device;
  std::unique_ptr<MemoryInUse> memory;
  WorldHits hits;
  std::shared_ptr<const WorldStatus> status;  // null if the host placed the worlds
  std::vector<graph::BufferId> onHost;        // hits for the host, in the order of their targets
  graph::Submission submission;

  void store() const {
    std::vector<MemoryCopy> copies;
    auto from = onHost.begin();
    for (const WorldCast::Target& target : hits.arrays) {
      if (!target.host || onHost.empty()) continue;
      copies.push_back(
          {target.host, submission.buffer(*from++).as<std::byte>(), bytesOf(target, hits.rays * hits.worlds)});
    }
    copyInParallel(copies);
  }
};

WorldCastTicket::WorldCastTicket(std::unique_ptr<Call> call) : call_(std::move(call)) {}
WorldCastTicket::WorldCastTicket(WorldCastTicket&&) noexcept = default;
WorldCastTicket& WorldCastTicket::operator=(WorldCastTicket&&) noexcept = default;
WorldCastTicket::~WorldCastTicket() = default;

bool WorldCastTicket::done() const {
  return !call_ || call_->submission.done();
}

WorldHits WorldCastTicket::take() {
  call_->submission.wait();  // an exception of Device::whileWaiting() must leave the hits for another call
  const std::unique_ptr<Call> call = std::move(call_);
  call->memory.reset();
  call->store();
  if (call->status) call->hits.worldStatus.assign(call->status->bits().begin(), call->status->bits().end());
  return std::move(call->hits);
}

WorldCastTicket Renderer::submitCast(WorldCast cast, const Settings& settings, const SceneState& moment) {
  checkRays(settings, cast.maxDistance);
  const uint64_t count = cast.rays * moment.worlds.count;
  assert(count <= kMaxWorldRays);
  for (WorldCast::Target& hits : cast.hits) {
    if (hits.host) continue;
    const uint64_t bytes = bytesOf(hits, std::max<uint64_t>(count, 1));
    if (!hits.memory) hits.memory = exports_->take(device_, bytes);
    if (hits.memory->buffer.size() < bytes)
      badUsage("the array of {} is too small for the hits of {} rays", hits.array->name, count);
  }
  const shared::FrameConstants constants = prepareRays(settings, moment);
  graph::Graph graph(executor_);
  shared::CastPush push{.frame = graph.constants(std::as_bytes(std::span(&constants, 1))),
                        .origins = cast.origins,
                        .directions = cast.directions,
                        .count = static_cast<uint32_t>(count),
                        .flags = flagsOf(scene_, settings, cast.doubles),
                        .perWorld = static_cast<uint32_t>(cast.rays),
                        .instanceCount = gpuScene_.instances().count()};
  const std::array<double, 7> numbers = numbersOf(gpuScene_.origin(), settings, cast.maxDistance);
  push.numbers = graph.constants(std::as_bytes(std::span(numbers)));
  auto call = std::make_unique<WorldCastTicket::Call>(device_, std::move(cast), moment.worlds);
  if (count == 0) return WorldCastTicket(std::move(call));
  const Builder builder{device_, graph};
  call->onHost = addWorldCast(builder, castPass(builder, push.count, rayConstants()), push, call->hits.arrays);
  addSceneChanges(graph);
  if (moment.worlds.inputs) call->status = worldPlacer_.conversion().status;
  call->submission = submit(graph, graph.compile());
  return WorldCastTicket(std::move(call));
}

}  // namespace latelight::render
