// `latelight bench rays`: rays per second on the device, by kind, and the time of Renderer::cast() on the host. A first
// graph writes the rays of each kind and what those of the camera hit. The measured graphs only trace.
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>

#include "base/stopwatch.h"
#include "render/base/readback.h"
#include "render/submit/renderer.h"
#include "study/bench.h"
#include "study/bench_rays_push.h"
#include "study/constant_ids.h"
#include "study/pass_samples.h"

namespace latelight::study {

namespace {

using graph::BufferId;
using graph::Use;
using render::Builder;
using render::RayPassInputs;

constexpr uint32_t kMaxCastRays = 1'000'000;

// The flags of glsl/rays.glsl that each kind of ray is traced with, in the order of kPrimaryRays and so on.
struct RayKind {
  const char* name;
  uint32_t traced;
};
constexpr RayKind kKinds[] = {{"primary rays", 0}, {"diffuse rays", 1}, {"shadow rays", 1 | 4}};

glm::uvec3 dispatchOf(uint32_t count) {
  return {std::min(count, shared::kBenchRow), (count + shared::kBenchRow - 1) / shared::kBenchRow, 1};
}

// The camera as bench_sources.comp reads it. The image has about `count` pixels, of which the last may be unused.
shared::BenchSourcesPush cameraPush(const scene::Camera& camera, glm::dvec3 deviceOrigin, uint32_t count) {
  constexpr double kAspect = 16.0 / 9;
  shared::BenchSourcesPush push{.orthographic = camera.orthographic, .count = count};
  push.width = std::max(8 * static_cast<uint32_t>(std::sqrt(count * kAspect) / 8), 8u);
  push.height = 4 * ((count + 4 * push.width - 1) / (4 * push.width));
  const double up = camera.orthographic ? double{camera.yHalf} : std::tan(0.5 * double{camera.verticalFov});
  glm::dmat3 axes(camera.toWorld);
  for (int i = 0; i < 3; ++i) axes[i] = glm::normalize(axes[i]);
  push.origin = glm::dvec3(camera.toWorld[3]) - deviceOrigin;
  push.direction = axes[1];
  push.across = axes[0] * (up * push.width / push.height);
  push.up = axes[2] * up;
  return push;
}

BufferId tracePass(const Builder& b, const RayPassInputs& inputs, const RayKind& kind, BufferId rays, uint32_t count) {
  const BufferId hits = b.graph.create(vk::BufferDesc{.size = count * sizeof(shared::BenchHit), .name = "hits"});
  std::vector<vk::Constant> constants = inputs.constants;
  constants.push_back({kTracedConstant, kind.traced});
  addCompute(b,
             {.stage = graph::Stage::Visibility,
              .name = kind.name,
              .shader = "bench_rays.comp",
              .bindings = render::Bindings(b.device),
              .size = dispatchOf(count),
              .constants = constants,
              .buffers = {{rays, Use::StorageRead}, {hits, Use::StorageWrite}},
              .groupX = 64,
              .groupY = 1},
             [=, frame = inputs.frame](graph::Context& c) {
               return shared::BenchRaysPush{frame, c.buffer(rays).address(), c.buffer(hits).address(), count};
             });
  return hits;
}

// Adds the pass that writes the rays of one kind, and counts those that have a surface to start from.
BufferId sourcePass(const Builder& b, const RayPassInputs& inputs, shared::BenchSourcesPush push, BufferId primary,
                    BufferId hits, BufferId used) {
  const BufferId rays = b.graph.create(vk::BufferDesc{.size = push.count * sizeof(shared::BenchRay), .name = "rays"});
  std::vector<graph::Access> accesses{{rays, Use::StorageWrite}, {used, Use::StorageReadWrite}};
  if (primary) accesses.insert(accesses.end(), {{primary, Use::StorageRead}, {hits, Use::StorageRead}});
  addCompute(b,
             {.stage = graph::Stage::Visibility,
              .name = "sources",
              .shader = "bench_sources.comp",
              .bindings = render::Bindings(b.device),
              .size = dispatchOf(push.count),
              .buffers = accesses,
              .groupX = 64,
              .groupY = 1},
             [=, frame = inputs.frame](graph::Context& c) {
               shared::BenchSourcesPush complete = push;
               complete.frame = frame;
               complete.primary = primary ? c.buffer(primary).address() : 0;
               complete.hits = primary ? c.buffer(hits).address() : 0;
               complete.rays = c.buffer(rays).address();
               complete.used = c.buffer(used).address() + push.kind * sizeof(uint32_t);
               return complete;
             });
  return rays;
}

// Adds passes that write and trace the rays of all kinds. Returns the numbers of used rays, readable by the host.
BufferId addKinds(const Builder& b, const RayPassInputs& inputs, const scene::Camera& camera, uint32_t count) {
  shared::BenchSourcesPush push = cameraPush(camera, inputs.origin, count);
  const BufferId used = b.graph.create(vk::BufferDesc{.size = std::size(kKinds) * sizeof(uint32_t), .name = "used"});
  addClear(b, graph::Stage::Visibility, "clear", {used});
  BufferId primary, hits;
  for (const RayKind& kind : kKinds) {
    const BufferId rays = sourcePass(b, inputs, push, primary, hits, used);
    const BufferId found = tracePass(b, inputs, kind, rays, count);
    b.graph.exports(found, Use::StorageRead);
    if (!primary) primary = rays, hits = found;
    ++push.kind;
  }
  return render::addReadback(b, used);
}

void addRow(Table& table, const std::string& name, double number, const Milliseconds& samples) {
  const double ms = median(samples);
  table.rows.push_back({name, number, ms, spread(samples), 1e-6 * number / ms, ""});
}

void addDeviceRates(Table& table, render::Renderer& renderer, const scene::Camera& camera,
                    const render::SceneState& moment, const render::Settings& settings, uint32_t count, uint32_t runs) {
  BufferId used;
  const auto run = [&] {
    return renderer.traceRays(
        [&](const Builder& b, const RayPassInputs& inputs) { used = addKinds(b, inputs, camera, count); }, settings,
        moment);
  };
  const Stopwatch stopwatch;
  while (stopwatch.seconds() < kWarmUp) run();
  PassSamples passes;
  graph::Submission last;
  for (uint32_t i = 0; i < runs; ++i) {
    last = run();
    passes.add(last.times());
  }
  const auto* numbers = last.buffer(used).as<uint32_t>();
  for (size_t i = 0; i < std::size(kKinds); ++i) addRow(table, kKinds[i].name, numbers[i], passes.of[kKinds[i].name]);
}

// Directions over the sphere at equal distances, by a Fibonacci lattice: neighbors in the array are far apart.
std::vector<glm::dvec3> allDirections(uint32_t count) {
  std::vector<glm::dvec3> directions(count);
  for (uint32_t i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, across = std::sqrt(1 - z * z), angle = glm::golden_ratio<double>() * i;
    directions[i] = {across * std::cos(2 * glm::pi<double>() * angle), across * std::sin(2 * glm::pi<double>() * angle),
                     z};
  }
  return directions;
}

void addCastTime(Table& table, render::Renderer& renderer, const scene::Camera& camera,
                 const render::SceneState& moment, const render::Settings& settings, uint32_t count, uint32_t runs) {
  const std::vector<glm::dvec3> directions = allDirections(count), origins(count, glm::dvec3(camera.toWorld[3]));
  const render::CastRays rays{origins, directions};
  const auto measure = [&](const char* name, const std::function<void()>& cast) {
    const auto milliseconds = [&] {
      const Stopwatch stopwatch;
      cast();
      return 1000 * stopwatch.seconds();
    };
    const Stopwatch stopwatch;
    while (stopwatch.seconds() < kWarmUp) milliseconds();
    Milliseconds samples;
    for (uint32_t run = 0; run < runs; ++run) samples.push_back(milliseconds());
    addRow(table, name, count, samples);
  };
  measure("cast(), host to host", [&] { renderer.cast(rays, settings, moment); });
  render::CastHits hits;
  render::HitMemory<render::CastTargets, render::CastHits> memory(hits, count);
  memory.wait();
  const render::CastTargets& all = memory.targets();
  measure("cast(), to arrays of the caller", [&] { renderer.cast(rays, all, settings, moment); });
  const render::CastTargets lidar{.distance = all.distance, .id = all.id, .intensity = all.intensity};
  measure("cast(), distance, id and intensity", [&] { renderer.cast(rays, lidar, settings, moment); });
}

}  // namespace

Table benchRays(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                const render::Settings& settings, uint32_t count, const BenchOptions& options) {
  Table table{"rays", {"measured", "number", "ms", "spread %", "G per second", "MB"}, {}};
  render::Settings world = settings;
  world.axes = render::Axes::ZUp;  // as the camera
  addDeviceRates(table, renderer, camera, moment, world, count, options.frames);
  addCastTime(table, renderer, camera, moment, world, std::min(count, kMaxCastRays), options.frames);
  const render::BvhStatistics bvhs = renderer.bvhStatistics();
  const auto triangles = static_cast<double>(bvhs.triangles);
  table.rows.push_back({"triangles of BVHs", triangles, 1000 * bvhs.buildSeconds, "",
                        1e-9 * triangles / bvhs.buildSeconds, 1e-6 * static_cast<double>(bvhs.bytes)});
  if (bvhs.deviceSeconds > 0)
    table.rows.push_back({"the same, on the device", triangles, 1000 * bvhs.deviceSeconds, "",
                          1e-9 * triangles / bvhs.deviceSeconds, ""});
  const render::BvhCosts costs = renderer.bvhCosts();
  table.rows.push_back({"cost of BVHs", costs.inUse, "", "", "", ""});
  table.rows.push_back({"cost, built on the host", costs.onHost, "", "", "", ""});
  return table;
}

}  // namespace latelight::study
