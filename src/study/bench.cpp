#include "study/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <glm/ext/matrix_transform.hpp>
#include <glm/gtc/constants.hpp>
#include <map>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "render/raster_choice.h"
#include "scene/builtin.h"

namespace latelight::study {

namespace {

using render::Raster;
using Samples = std::vector<double>;  // milliseconds

constexpr Raster kRasters[] = {Raster::Hardware, Raster::Compute};

double quantile(Samples samples, double at) {
  if (samples.empty()) return 0;
  std::ranges::sort(samples);
  return samples[static_cast<size_t>(at * static_cast<double>(samples.size() - 1) + 0.5)];
}
double median(const Samples& samples) {
  return quantile(samples, 0.5);
}
// Half of the samples lie within this many per cent of the median, together.
double spread(const Samples& samples) {
  const double middle = median(samples);
  return middle > 0 ? 100 * (quantile(samples, 0.75) - quantile(samples, 0.25)) / middle : 0;
}

// Each frame's passes by name, in the order of their first appearance.
struct PassSamples {
  std::vector<std::string> names;
  std::map<std::string, Samples> of;
  Samples all;

  void add(std::span<const graph::PassTime> passes) {
    std::map<std::string, double> frame;
    double sum = 0;
    for (const graph::PassTime& pass : passes) {
      if (!of.contains(pass.name)) names.push_back(pass.name);
      of[pass.name];
      frame[pass.name] += pass.milliseconds;
      sum += pass.milliseconds;
    }
    for (const auto& [name, milliseconds] : frame) of[name].push_back(milliseconds);
    all.push_back(sum);
  }
};

// The camera, turned about its eye.
scene::Camera turned(scene::Camera camera, double angle) {
  const glm::vec4 eye = camera.toWorld[3];
  camera.toWorld = glm::rotate(glm::mat4(1), static_cast<float>(angle), glm::vec3(0, 0, 1)) * camera.toWorld;
  camera.toWorld[3] = eye;
  return camera;
}

// The rasters take turns, so that whatever else the machine does falls on both. The camera turns a little from frame to
// frame: what is kept for a later frame is what does not depend on the view.
std::map<Raster, PassSamples> measure(render::Renderer& renderer, const scene::Camera& camera,
                                      const render::Moment& moment, const render::Settings& settings, uint32_t frames) {
  constexpr double kTurn = 1e-3;  // radians a frame
  std::map<Raster, PassSamples> samples;
  for (uint32_t frame = 0; frame <= frames; ++frame)
    for (const Raster raster : kRasters) {
      render::Settings s = settings;
      s.raster = raster;
      const scene::Camera now = turned(camera, frame * kTurn);
      renderer.submit({&now, 1}, s, moment, render::Results::OnDevice).take();
      if (frame > 0) samples[raster].add(renderer.times());
    }
  return samples;
}

// --- raster ---------------------------------------------------------------------------------------------------------

struct Random {
  const char* count;
  uint32_t tenths;  // of a pixel
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
      return render::depthTimes(renderer, scene, raster, scene::kTrianglesPicture, options.frames);
    };
    const Samples hardware = times(Raster::Hardware), compute = times(Raster::Compute);
    table.rows.push_back({std::string(row.count), 0.1 * row.tenths, median(hardware), spread(hardware), median(compute),
                          spread(compute), median(hardware) / median(compute)});
  }
  return table;
}

Table benchFrame(render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment,
                 const render::Settings& settings, const BenchOptions& options) {
  const std::map<Raster, PassSamples> samples = measure(renderer, camera, moment, settings, options.frames);
  Table table{"frame", {"raster", "pass", "ms", "spread %"}, {}};
  for (const Raster raster : kRasters) {
    const std::string name(render::nameOf(raster));
    const PassSamples& passes = samples.at(raster);
    for (const std::string& pass : passes.names)
      table.rows.push_back({name, pass, median(passes.of.at(pass)), spread(passes.of.at(pass))});
    table.rows.push_back({name, std::string("all"), median(passes.all), spread(passes.all)});
  }
  const double ratio = median(samples.at(Raster::Hardware).all) / median(samples.at(Raster::Compute).all);
  table.rows.push_back({std::string("hardware / compute"), std::string("all"), ratio, 0.0});
  return table;
}

// --- views ----------------------------------------------------------------------------------------------------------

namespace {

std::vector<scene::Camera> allAround(const scene::Camera& camera, uint32_t count) {
  std::vector<scene::Camera> cameras;
  for (uint32_t i = 0; i < count; ++i) cameras.push_back(turned(camera, 2 * glm::pi<double>() * i / count));
  return cameras;
}

// Milliseconds until the device is done. The first call takes what is found too small, and the pictures, to its end.
double timeOfViews(render::Renderer& renderer, std::span<const scene::Camera> cameras, const render::Poses& poses,
                   const render::Settings& settings, bool first) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  render::Ticket ticket = renderer.submit(cameras, settings, {.poses = poses}, render::Results::OnDevice);
  while (!ticket.done()) std::this_thread::sleep_for(std::chrono::microseconds(50));
  const double elapsed = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  if (first) ticket.take();
  return elapsed;
}

}  // namespace

Table benchViews(render::Renderer& renderer, const scene::Camera& camera, const render::Poses& poses,
                 const render::Settings& settings, uint32_t count, const BenchOptions& options) {
  constexpr uint32_t kWarm = 4;
  const std::vector<scene::Camera> cameras = allAround(camera, count);
  Table table{"views", {"raster", "views", "ms", "spread %", "views a second"}, {}};
  for (const Raster raster : kRasters) {
    render::Settings s = settings;
    s.raster = raster;
    timeOfViews(renderer, cameras, poses, s, true);
    // Results that are left on the device have their memory from earlier calls, once there are enough of those.
    for (uint32_t run = 0; run < kWarm; ++run) timeOfViews(renderer, cameras, poses, s, false);
    Samples samples;
    for (uint32_t run = 0; run < options.frames; ++run)
      samples.push_back(timeOfViews(renderer, cameras, poses, s, false));
    table.rows.push_back({std::string(render::nameOf(raster)), static_cast<double>(count), median(samples),
                          spread(samples), 1000 * count / median(samples)});
  }
  return table;
}

}  // namespace latelight::study
