#include "study/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/stopwatch.h"
#include "render/submit/raster_choice.h"
#include "render/submit/session.h"
#include "scene/builtin/builtin.h"
#include "scene/file_frame.h"
#include "scene/load/load.h"
#include "study/pass_samples.h"

namespace latelight::study {

namespace {

using render::Raster;

// --- raster ---------------------------------------------------------------------------------------------------------

struct Random {
  const char* count;
  uint32_t tenths;  // tenths of a pixel
};
constexpr Random kRandom[] = {{"100k", 20}, {"1M", 15},    {"10M", 15},  {"10M", 40},
                              {"1M", 160},  {"100k", 640}, {"10k", 4000}};

}  // namespace

uint64_t minRasterTriangles() {
  const auto count = [](const Random& row) { return *scene::parseCount(row.count); };
  return count(*std::ranges::min_element(kRandom, {}, count));
}

Table benchRaster(vk::Device& device, const BenchOptions& options) {
  Table table{"raster",
              {"triangles", "size px", "hardware ms", "spread %", "compute ms", "spread %", "hardware / compute"},
              {}};
  for (const Random& row : kRandom) {
    const uint64_t count = *scene::parseCount(row.count);
    if (count > options.maxTriangles) continue;
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

Table benchFrame(const vk::Device& device, render::Renderer& renderer, const scene::Camera& camera,
                 const render::SceneState& moment, const render::Settings& settings, const Ceilings& ceilings,
                 const BenchOptions& options) {
  const std::vector<Raster> rasters = render::possibleRasters(device, settings, std::span(&camera, 1));
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
  const glm::dvec3 middle = inside ? eye : bounds.center();
  std::vector<scene::Camera> cameras;
  for (uint32_t i = 0; i < count; ++i) cameras.push_back(turned(camera, 2 * glm::pi<double>() * i / count, middle));
  return cameras;
}

struct TimedViews {
  render::Ticket ticket;
  double host, milliseconds;  // until the last view is submitted, and until the device is done
};

TimedViews timeViews(render::Renderer& renderer, std::span<const scene::Camera> cameras,
                     const render::SceneState& moment, const render::Settings& settings) {
  const Stopwatch stopwatch;
  render::Ticket ticket = renderer.submit(cameras, settings, moment, render::Results::OnDevice);
  const double host = 1000 * stopwatch.seconds();
  while (!ticket.done()) std::this_thread::sleep_for(std::chrono::microseconds(50));
  return {std::move(ticket), host, 1000 * stopwatch.seconds()};
}

// Adds rows for one raster, which renders `views` views. momentOf(run) returns the scene's state in a run, which is not
// part of the time.
template <typename MomentOf>
void addViews(Table& table, render::Renderer& renderer, std::span<const scene::Camera> cameras, size_t views,
              const render::Settings& settings, const BenchOptions& options, const MomentOf& momentOf) {
  constexpr uint32_t kWarm = 4;
  uint32_t number = 0;
  const auto next = [&] { return timeViews(renderer, cameras, momentOf(number++), settings); };
  next().ticket.take();  // resolves overflow
  // Warm up until results that stay on the device reuse memory of earlier calls.
  const Stopwatch stopwatch;
  for (uint32_t run = 0; run < kWarm || stopwatch.seconds() < kWarmUp; ++run) next();
  Milliseconds host, samples;
  for (uint32_t run = 0; run < options.frames; ++run) {
    const TimedViews timed = next();
    host.push_back(timed.host);
    samples.push_back(timed.milliseconds);
  }
  PassSamples passes;
  passes.add(next().ticket.take().statistics.passTimes);
  const std::string name(render::nameOf(settings.raster));
  for (const std::string& pass : passes.names) table.rows.push_back({name, pass, median(passes.of.at(pass)), "", ""});
  table.rows.push_back({name, std::string("host, until submitted"), median(host), spread(host), ""});
  table.rows.push_back({name, std::string("all, until done"), median(samples), spread(samples),
                        1000 * static_cast<double>(views) / median(samples)});
}

// The states of worlds in one run: instances turn about their own vertical axes.
render::WorldStates turningWorlds(const scene::Scene& scene, uint32_t count, uint32_t run) {
  render::WorldStates worlds{.count = count};
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (!scene.instances[i].removed) worlds.instances.push_back(i);
  for (uint32_t world = 0; world < count; ++world)
    for (const uint32_t instance : worlds.instances) {
      const double angle = 0.1 * std::sin(1.0 + world + 0.3 * run + instance);
      worlds.transforms.push_back(glm::rotate(scene.instances[instance].toWorld, angle, glm::dvec3(0, 1, 0)));
    }
  return worlds;
}

// Appends a matrix row by row.
void append(std::vector<double>& rows, const glm::dmat4& matrix) {
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) rows.push_back(matrix[column][row]);
}

// The same states, and a camera per world, as arrays on the device, which shaders convert.
render::WorldStates turningWorldsOnDevice(vk::Device& device, const scene::Scene& scene,
                                          std::span<const scene::Camera> cameras, uint32_t run) {
  const auto count = static_cast<uint32_t>(cameras.size());
  render::WorldStates worlds = turningWorlds(scene, count, run);
  const glm::dmat4 fileFromWorld = glm::inverse(scene::worldFromFile(scene));
  std::vector<double> transforms, poses;
  for (const glm::dmat4& transform : worlds.transforms) append(transforms, fileFromWorld * transform);
  for (const scene::Camera& camera : cameras) append(poses, render::openCvPose(camera, scene, false));
  worlds.transforms.clear();
  render::WorldInputs& inputs = worlds.inputs.emplace();
  inputs.cameras = {cameras.front()};
  vk::Uploader uploader(device);
  const auto give = [&](const std::vector<double>& numbers, const char* name) {
    const auto bytes = std::as_bytes(std::span(numbers));
    const auto buffer = std::make_shared<const vk::Buffer>(device, vk::BufferDesc{.size = bytes.size(), .name = name});
    uploader.upload(*buffer, bytes);
    inputs.memory.push_back(buffer);
    return render::WorldArray{.address = buffer->address(), .element = shared::kNumberDouble};
  };
  inputs.transforms = give(transforms, "transforms");
  inputs.cameraToWorld = give(poses, "poses");
  uploader.flush();
  return worlds;
}

Table viewsTable(const char* name) {
  return {name, {"raster", "pass", "ms", "spread %", "views per second"}, {}};
}

}  // namespace

Table benchViews(const vk::Device& device, render::Renderer& renderer, const scene::Scene& scene,
                 const scene::Camera& camera, const render::Poses& poses, const render::Settings& settings,
                 uint32_t count, const BenchOptions& options) {
  const std::vector<scene::Camera> cameras = allAround(scene, camera, count);
  Table table = viewsTable("views");
  for (const Raster raster : render::possibleRasters(device, settings, cameras)) {
    render::Settings s = settings;
    s.raster = raster;
    addViews(table, renderer, cameras, cameras.size(), s, options,
             [&](uint32_t) { return render::SceneState{.poses = poses}; });
  }
  return table;
}

Table benchWorlds(vk::Device& device, render::Renderer& renderer, const scene::Scene& scene,
                  const scene::Camera& camera, const render::Poses& poses, const render::Settings& settings,
                  uint32_t count, const BenchOptions& options) {
  std::vector<scene::Camera> cameras = allAround(scene, camera, count);
  for (uint32_t world = 0; world < count; ++world) cameras[world].world = world;
  Table table = viewsTable("worlds");
  for (const Raster raster : render::possibleRasters(device, settings, cameras)) {
    render::Settings s = settings;
    s.raster = raster;
    if (renderer.placesWorlds(s, cameras, poses, render::Renderer::WorldLights::OfScene, false)) {
      const std::array states{turningWorldsOnDevice(device, scene, cameras, 0),
                              turningWorldsOnDevice(device, scene, cameras, 1)};
      addViews(table, renderer, std::span(cameras).first(1), count, s, options,
               [&](uint32_t run) { return render::SceneState{.poses = poses, .worlds = states[run % states.size()]}; });
      continue;
    }
    addViews(table, renderer, cameras, count, s, options, [&](uint32_t run) {
      return render::SceneState{.poses = poses, .worlds = turningWorlds(scene, count, run)};
    });
  }
  return table;
}

}  // namespace latelight::study
