#include "study/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <glm/gtc/constants.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/stopwatch.h"
#include "render/submit/raster_choice.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"
#include "study/pass_samples.h"

namespace latelight::study {

namespace {

using render::Raster;
constexpr Raster kRasters[] = {Raster::Hardware, Raster::Compute};

// Returns the rasters that can render these settings.
std::span<const Raster> rastersOf(const render::Settings& settings) {
  return std::span(kRasters).subspan(render::takesCompute(settings) ? 1 : 0);
}

// --- raster ---------------------------------------------------------------------------------------------------------

struct Random {
  const char* count;
  uint32_t tenths;  // tenths of a pixel
};
constexpr Random kRandom[] = {{"100k", 20}, {"1M", 15},    {"10M", 15},  {"10M", 40},
                              {"1M", 160},  {"100k", 640}, {"10k", 4000}};

}  // namespace

Table benchRaster(vk::Device& device, const BenchOptions& options) {
  Table table{"raster",
              {"triangles", "size px", "hardware ms", "spread %", "compute ms", "spread %", "hardware / compute"},
              {}};
  for (const Random& row : kRandom) {
    const uint64_t count = *scene::parseCount(row.count);
    if (count > options.mostTriangles) continue;
    const scene::Scene scene = scene::load(fmt::format("builtin:triangles,count={},size={}", row.count, row.tenths));
    render::Renderer renderer(device, scene, nullptr);
    const auto times = [&](Raster raster) {
      return render::depthTimes(renderer, scene, raster, scene::kTrianglesPicture, options.frames, kWarmUp);
    };
    const Milliseconds hardware = times(Raster::Hardware), compute = times(Raster::Compute);
    table.rows.push_back({std::string(row.count), 0.1 * row.tenths, median(hardware), spread(hardware), median(compute),
                          spread(compute), median(hardware) / median(compute)});
  }
  return table;
}

Table benchFrame(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                 const render::Settings& settings, const Ceilings& ceilings, const BenchOptions& options) {
  const std::span<const Raster> rasters = rastersOf(settings);
  std::vector<render::Settings> each(rasters.size(), settings);
  for (size_t i = 0; i < each.size(); ++i) each[i].raster = rasters[i];
  const std::vector<PassSamples> samples = measureInterleaved(renderer, camera, moment, each, options.frames);
  Table table{"frame", {"raster", "pass", "ms", "spread %", "MB", "% of copies"}, {}};
  for (size_t i = 0; i < each.size(); ++i) {
    const std::string name(render::nameOf(rasters[i]));
    const PassSamples& passes = samples[i];
    for (const std::string& pass : passes.names) {
      const double ms = median(passes.of.at(pass));
      std::vector<Cell>& row = table.rows.emplace_back(std::vector<Cell>{name, pass, ms, spread(passes.of.at(pass))});
      addCopyCells(row, ceilings, passes.trafficBytes.at(pass), ms);
    }
    table.rows.push_back({name, std::string("all"), median(passes.all), spread(passes.all), "", ""});
  }
  if (rasters.size() == 1) return table;
  const double ratio = median(samples.front().all) / median(samples.back().all);
  table.rows.push_back({std::string("hardware / compute"), std::string("all"), ratio, 0.0, "", ""});
  return table;
}

// --- views ----------------------------------------------------------------------------------------------------------

namespace {

// Inside a scene the camera turns in place; from outside it orbits the scene.
std::vector<scene::Camera> allAround(const scene::Scene& scene, const scene::Camera& camera, uint32_t count) {
  const scene::Bounds bounds = scene::worldBounds(scene);
  const glm::dvec3 eye(camera.toWorld[3]);
  const bool inside = glm::all(glm::greaterThan(eye, bounds.min)) && glm::all(glm::lessThan(eye, bounds.max));
  const glm::dvec3 middle = inside ? eye : bounds.centre();
  std::vector<scene::Camera> cameras;
  for (uint32_t i = 0; i < count; ++i) cameras.push_back(turned(camera, 2 * glm::pi<double>() * i / count, middle));
  return cameras;
}

struct TimedViews {
  render::Ticket ticket;
  double milliseconds;  // until the device is done
};

TimedViews timeViews(render::Renderer& renderer, std::span<const scene::Camera> cameras, const render::Poses& poses,
                     const render::Settings& settings) {
  const Stopwatch stopwatch;
  render::Ticket ticket = renderer.submit(cameras, settings, {.poses = poses}, render::Results::OnDevice);
  while (!ticket.done()) std::this_thread::sleep_for(std::chrono::microseconds(50));
  return {std::move(ticket), 1000 * stopwatch.seconds()};
}

}  // namespace

Table benchViews(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                 const render::Poses& poses, const render::Settings& settings, uint32_t count,
                 const BenchOptions& options) {
  constexpr uint32_t kWarm = 4;
  const std::vector<scene::Camera> cameras = allAround(scene, camera, count);
  Table table{"views", {"raster", "pass", "ms", "spread %", "views a second"}, {}};
  for (const Raster raster : rastersOf(settings)) {
    render::Settings s = settings;
    s.raster = raster;
    timeViews(renderer, cameras, poses, s).ticket.take();  // resolves overflow
    // Warm up until results that stay on the device reuse memory of earlier calls.
    const Stopwatch stopwatch;
    for (uint32_t run = 0; run < kWarm || stopwatch.seconds() < kWarmUp; ++run) timeViews(renderer, cameras, poses, s);
    Milliseconds samples;
    for (uint32_t run = 0; run < options.frames; ++run)
      samples.push_back(timeViews(renderer, cameras, poses, s).milliseconds);
    PassSamples passes;
    passes.add(timeViews(renderer, cameras, poses, s).ticket.take().statistics.passTimes);
    const std::string name(render::nameOf(raster));
    for (const std::string& pass : passes.names) table.rows.push_back({name, pass, median(passes.of.at(pass)), "", ""});
    table.rows.push_back(
        {name, std::string("all, until done"), median(samples), spread(samples), 1000 * count / median(samples)});
  }
  return table;
}

}  // namespace latelight::study
