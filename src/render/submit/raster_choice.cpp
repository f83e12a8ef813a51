#include "render/submit/raster_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>

#include "base/error.h"
#include "base/files.h"
#include "base/fork.h"
#include "base/stopwatch.h"
#include "render/frame/view.h"
#include "render/lighting/technique.h"
#include "render/outputs/outputs.h"
#include "render/rays/worlds/world_bvh.h"
#include "render/submit/lens_settings.h"
#include "render/submit/request.h"
#include "render/visibility/compute/compute.h"
#include "scene/load/load.h"
#include "scene/scene.h"

namespace latelight::render {

namespace {

constexpr const char* kScene = "builtin:triangles,count=300k,size=30";

struct Times {  // milliseconds on the device
  double hardware, compute;
};

double timeOf(Renderer& renderer, const scene::Scene& scene, Raster raster) {
  return std::ranges::min(depthTimes(renderer, scene, raster, 1024, 3));
}

Times measure(vk::Device& device) {
  const scene::Scene scene = scene::load(kScene);
  Renderer renderer(device, scene, nullptr);
  return {timeOf(renderer, scene, Raster::Hardware), timeOf(renderer, scene, Raster::Compute)};
}

// Returns the times from this process, from the cache folder, or by measurement.
Times knownTimes(vk::Device& device) {
  static ForkSafeMutex mutex;
  static std::map<std::string, Times> known;
  const std::string entry = fmt::format("raster1-{}-{:08x}", device.info().uuid, device.properties().driverVersion);
  std::lock_guard lock(mutex);
  if (const auto found = known.find(entry); found != known.end()) return found->second;
  Times times;
  if (const auto bytes = loadCache(entry); bytes && bytes->size() == sizeof(times)) {
    std::memcpy(&times, bytes->data(), sizeof(times));
  } else {
    times = measure(device);
    storeCache(entry, std::as_bytes(std::span(&times, 1)));
  }
  return known[entry] = times;
}

// Returns the choice if the device and the settings support only one raster.
std::optional<RasterChoice> onlyChoice(const vk::Device& device, const Settings& settings) {
  const std::string lacks = missingForComputeRaster(device);
  if (!device.hasGraphics()) {
    if (!lacks.empty()) fail(ExitCode::NoDevice, "{} has no graphics queue, and {}.", device.info().name, lacks);
    return RasterChoice{Raster::Compute, "the device has no graphics pipeline"};
  }
  if (lightsTriangles(settings)) {
    if (!lacks.empty())
      fail(ExitCode::NoDevice,
           "{} cannot rasterize in compute, which the layout {} requires: {}; choose another layout.",
           device.info().name, settings.layout->name, lacks);
    return RasterChoice{Raster::Compute, "the layout has no targets that hardware could draw"};
  }
  if (takesCompute(settings)) {
    if (!lacks.empty())
      fail(ExitCode::NoDevice, "{} cannot rasterize in compute, which msaa{} requires: {}; choose msaa4.",
           device.info().name, settings.aa.samples, lacks);
    return RasterChoice{Raster::Compute, "hardware has no such number of samples per pixel"};
  }
  if (!lacks.empty()) return RasterChoice{Raster::Hardware, lacks};
  if (alwaysDraws(settings))
    return RasterChoice{Raster::Hardware, "forward techniques are drawn, and volumes of several samples per pixel"};
  return std::nullopt;
}

// Returns the number of triangles above which the raster compute is faster if its shaders have to filter textures
// themselves. The formulas follow the crossings on lavapipe, docs/performance.md#which-raster-on-two-cores.
uint64_t mostForHardware(const Settings& settings, RasterUse use) {
  const double pixels = double(settings.width) * settings.height;
  if (use != RasterUse::Image) return textureSlots(settings) == 0 ? 0 : uint64_t(0.7 * pixels);
  if (textureSlots(settings) == 0) return 200'000;
  return uint64_t(settings.aa.samples > 1 ? 2e5 + 0.45 * pixels : 8e5 + 0.8 * pixels);
}

RasterChoice chooseWithoutIndexing(const Settings& settings, const scene::Scene& scene, RasterUse use) {
  const uint64_t most = mostForHardware(settings, use);
  return {scene.triangleCount() > most ? Raster::Compute : Raster::Hardware,
          fmt::format("without descriptor indexing, compute is faster above {} triangles at {}x{}", most,
                      settings.width, settings.height)};
}

// On processors, rasterization takes longer for each triangle of a view, and rays only for each sample. Above this
// number of triangles per sample, rays are faster for objects, by up to 26 times, and at worst somewhat slower in rooms
// whose walls hide most triangles. docs/performance.md#which-raster-on-two-cores has the measurements.
constexpr double kTrianglesPerRay = 30;
// Rays build a hierarchy over the instances of each world in each call, which takes as long as they save if instances
// have few triangles.
constexpr uint64_t kMinTrianglesPerInstance = 100;

// Returns true if rays are the faster raster for these worlds, and supported.
bool choosesRays(const vk::Device& device, const Settings& settings, const scene::Scene& scene, RasterUse use) {
  if (use != RasterUse::Worlds || !device.isCpu() || requestsOutput(settings, Origin::Raster)) return false;
  const uint64_t triangles = scene.triangleCount(), instances = scene.instances.size();
  const double samples = double(settings.width) * settings.height * settings.aa.samples;
  return triangles > kTrianglesPerRay * samples && triangles > kMinTrianglesPerInstance * instances &&
         missingForRaysInWorlds(device, instances).empty();
}

}  // namespace

std::vector<double> depthTimes(Renderer& renderer, const scene::Scene& scene, Raster raster, uint32_t size,
                               uint32_t frames, double warmUp) {
  Settings settings;
  settings.width = settings.height = size;
  settings.display = false;
  settings.shadows = ShadowFormat::None;
  settings.raster = raster;
  settings.aovs = {output::Aov::Depth};
  const auto timeOfFrame = [&] {
    const RenderResult result =
        renderer.submit(std::span(scene.cameras).first(1), settings, {}, Results::OnDevice).take();
    double sum = 0;
    for (const graph::PassTime& pass : result.statistics.passTimes)
      if (pass.stage == graph::Stage::Visibility) sum += pass.milliseconds;
    return sum;
  };
  timeOfFrame();  // creates pipelines, and the raster's data of the scene
  const Stopwatch stopwatch;
  while (stopwatch.seconds() < warmUp) timeOfFrame();
  std::vector<double> times;
  for (uint32_t frame = 0; frame < frames; ++frame) times.push_back(timeOfFrame());
  return times;
}

std::vector<Raster> possibleRasters(const vk::Device& device, const Settings& settings,
                                    std::span<const scene::Camera> cameras) {
  const Settings s = std::ranges::any_of(cameras, bendsRays) ? lensSettings(settings) : settings;
  if (s.raster != Raster::Auto)
    return {!rastersInCompute(s) ? Raster::Hardware : tracesVisibility(s) ? Raster::Rays : Raster::Compute};
  if (const auto only = onlyChoice(device, s)) return {only->raster};
  return {Raster::Hardware, Raster::Compute};
}

RasterChoice chooseRaster(vk::Device& device, const Settings& settings, const scene::Scene& scene, RasterUse use) {
  if (settings.raster != Raster::Auto) return {settings.raster, "it was asked for"};
  if (const auto only = onlyChoice(device, settings)) return *only;
  if (choosesRays(device, settings, scene, use))
    return {Raster::Rays, fmt::format("rays are faster on a processor if there are more than {} triangles per sample",
                                      kTrianglesPerRay)};
  if (device.maxTextureArray() == 0) return chooseWithoutIndexing(settings, scene, use);
  const Times times = knownTimes(device);
  return {times.compute < times.hardware ? Raster::Compute : Raster::Hardware,
          fmt::format("300,000 small triangles take {:.3f} ms with hardware and {:.3f} with compute", times.hardware,
                      times.compute)};
}

}  // namespace latelight::render
