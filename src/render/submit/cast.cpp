#include "render/submit/cast.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>

#include "base/error.h"
#include "base/parallel.h"
#include "render/base/readback.h"
#include "render/base/remainder.h"
#include "render/options/options.h"
#include "render/rays/cast_push.h"
#include "render/submit/job.h"
#include "render/submit/renderer.h"

namespace latelight::render {

namespace {

constexpr size_t kRaysAtOnce = size_t{1} << 18;
constexpr size_t kChunksInFlight = 2;
constexpr size_t kRaysOfTask = 8192;

bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Returns the unit vector of a direction of any length; not finite for directions without one.
glm::dvec3 unitOf(const glm::dvec3& direction) {
  const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  const glm::dvec3 scaled = direction / largest;
  return scaled / glm::length(scaled);  // squares of the quotient neither overflow nor underflow
}

// A coordinate frame of rays, relative to the device's world space.
struct RayFrame {
  glm::dmat3 worldFromFrame;
  glm::dvec3 deviceOrigin;    // in world space
  glm::dvec3 positionOrigin;  // in the frame

  shared::CastRay toDevice(const glm::dvec3& origin, const glm::dvec3& direction, double maxDistance) const {
    const glm::dvec3 from = worldFromFrame * origin - deviceOrigin, unit = worldFromFrame * unitOf(direction);
    if (!isFinite(from) || !isFinite(unit)) return {.near = 1, .far = 0};  // hits nothing
    shared::CastRay ray{.origin = glm::vec3(from), .near = 0, .direction = glm::vec3(unit)};
    ray.far = static_cast<float>(std::min(maxDistance, double{std::numeric_limits<float>::max()}));
    ray.originLow = remainderOf(from);
    ray.directionLow = remainderOf(unit);
    return ray;
  }
};

// Each array on its own thread, because the system clears the memory of large ones.
void resize(CastHits& hits, size_t count) {
  const std::function<void()> arrays[] = {
      [&] { hits.distance.resize(count); }, [&] { hits.intensity.resize(count); }, [&] { hits.position.resize(count); },
      [&] { hits.normal.resize(count); },   [&] { hits.geonormal.resize(count); }, [&] { hits.uv.resize(count); },
      [&] { hits.id.resize(count); },       [&] { hits.part.resize(count); },      [&] { hits.material.resize(count); },
      [&] { hits.triangle.resize(count); },
  };
  parallelFor(std::size(arrays), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) arrays[i]();
  });
}

// The position follows from the ray in double precision, so it is as precise as the distance.
void store(const shared::CastHit& hit, const CastRays& rays, const RayFrame& frame, size_t ray, CastHits& hits) {
  hits.distance[ray] = hit.distance;
  hits.id[ray] = hit.id, hits.part[ray] = hit.part, hits.material[ray] = hit.material;
  hits.triangle[ray] = hit.triangle;
  hits.uv[ray] = hit.uv, hits.intensity[ray] = hit.intensity;
  if (std::isinf(hit.distance)) return;
  const glm::dvec3 along = unitOf(rays.directions[ray]) * double{hit.distance};
  hits.position[ray] = glm::vec3(rays.origins[ray] - frame.positionOrigin + along);
  const glm::dmat3 frameFromWorld = glm::transpose(frame.worldFromFrame);
  hits.normal[ray] = glm::vec3(frameFromWorld * glm::dvec3(hit.normal));
  hits.geonormal[ray] = glm::vec3(frameFromWorld * glm::dvec3(hit.geonormal));
}

// Rays in flight.
struct CastChunk {
  size_t first, count;
  std::shared_ptr<const vk::Buffer> rays;
  graph::BufferId hits;  // readable by the host
  graph::Submission submission;
};

// Adds the pass that casts the first `count` rays of a buffer that the host has written. Returns their hits.
graph::BufferId addCast(const Builder& b, const shared::FrameConstants& frame, const vk::Buffer& rays, size_t rayCount,
                        uint32_t what, const std::vector<vk::Constant>& constants, graph::Graph& graph) {
  graph::BufferId source = graph.import(rays, std::nullopt);
  if (!b.device.isCpu()) {
    const graph::BufferId staged = source,
                          local =
                              graph.create(vk::BufferDesc{.size = rayCount * sizeof(shared::CastRay), .name = "rays"});
    graph.pass(graph::Stage::Upload, "upload rays", {{staged, graph::Use::CopySource}, {local, graph::Use::CopyTarget}},
               [=](graph::Context& context) {
                 const VkBufferCopy all{0, 0, context.buffer(local).size()};
                 vkCmdCopyBuffer(context.get(), context.buffer(staged).get(), context.buffer(local).get(), 1, &all);
               });
    source = local;
  }
  const graph::BufferId hits = createResult(b, "hits", rayCount * sizeof(shared::CastHit), 1).buffer;
  const VkDeviceAddress address = graph.constants(std::as_bytes(std::span(&frame, 1)));
  const auto count = static_cast<uint32_t>(rayCount);
  addCompute(b,
             {.stage = graph::Stage::Visibility,
              .name = "cast rays",
              .shader = "cast.comp",
              .bindings = Bindings(b.device),
              .size = {count, 1, 1},
              .constants = constants,
              .buffers = {{source, graph::Use::StorageRead}, {hits, graph::Use::StorageWrite}},
              .groupX = 64,
              .groupY = 1},
             [=](graph::Context& context) {
               return shared::CastPush{.frame = address,
                                       .rays = context.buffer(source).address(),
                                       .hits = context.buffer(hits).address(),
                                       .count = count,
                                       .what = what};
             });
  return addReadback(b, hits);
}

}  // namespace

shared::FrameConstants Renderer::prepareRays(const Settings& settings, const SceneState& moment) {
  resolveOverflow();
  sceneInput_.reset();
  gpuScene_.update(moment.poses, sunOf(settings));
  gpuScene_.setWorlds({}, moment.poses, {});
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
  checkSettings(settings);
  if (rays.origins.size() != rays.directions.size())
    badUsage("{} rays have an origin, but {} have a direction", rays.origins.size(), rays.directions.size());
  if (!(rays.maxDistance >= 0)) badUsage("the maximum distance of rays must be at least 0, not {}", rays.maxDistance);
  if (settings.normalFrame != NormalFrame::World)
    badUsage("rays have no camera: their normals require --normal-frame world");
  const shared::FrameConstants constants = prepareRays(settings, moment);
  const bool file = scene_.yUp && settings.axes == Axes::File;
  const RayFrame frame{.worldFromFrame = file ? glm::dmat3(scene::toWorldFromGltf()) : glm::dmat3(1),
                       .deviceOrigin = gpuScene_.origin(),
                       .positionOrigin = settings.positionOrigin.point};
  const std::vector<vk::Constant> specialized = rayConstants();
  const uint32_t what = settings.dataSurfaces == DataSurfaces::Any ? shared::kCastAnySurface : 0u;
  CastResult result{.hits = {}, .statistics = {}, .bvhBytes = bvh_->bytes()};
  resize(result.hits, rays.origins.size());
  std::deque<CastChunk> inFlight;
  const auto finishFirst = [&] {
    const CastChunk chunk = std::move(inFlight.front());
    inFlight.pop_front();
    chunk.submission.wait();
    const auto* hits = chunk.submission.buffer(chunk.hits).as<shared::CastHit>();
    parallelFor(chunk.count, kRaysOfTask, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) store(hits[i], rays, frame, chunk.first + i, result.hits);
    });
    addTimes(result.statistics.passTimes, chunk.submission);
  };
  // The host converts the rays of one chunk while the device casts those of the chunk before.
  for (size_t first = 0; first < rays.origins.size(); first += kRaysAtOnce) {
    if (inFlight.size() == kChunksInFlight) finishFirst();
    const size_t count = std::min(kRaysAtOnce, rays.origins.size() - first);
    const auto staging = inputMemory(std::min(kRaysAtOnce, rays.origins.size()) * sizeof(shared::CastRay));
    parallelFor(count, kRaysOfTask, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i)
        staging->as<shared::CastRay>()[i] =
            frame.toDevice(rays.origins[first + i], rays.directions[first + i], rays.maxDistance);
    });
    graph::Graph graph(executor_);
    const graph::BufferId hits = addCast({device_, graph}, constants, *staging, count, what, specialized, graph);
    addSceneChanges(graph);
    inFlight.push_back({first, count, staging, hits, submit(graph, graph.compile())});
  }
  while (!inFlight.empty()) finishFirst();
  return result;
}

}  // namespace latelight::render
