// `latelight bench`: measures device times pass by pass, alternating between the rasters that are possible unless
// --raster chooses one.
#include "study/bench.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/parse.h"
#include "app/render_options.h"
#include "app/render_run.h"
#include "base/log.h"
#include "render/lighting/technique.h"
#include "render/submit/session.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"
#include "vk/driver_cache.h"
#include "vk/shaders.h"

namespace latelight::app {

namespace {

struct BenchArguments {
  RenderOptions render;
  std::string most = "10M", rays = "4M", lights = "1,100,1k,10k,100k,1M";
  uint32_t views = 1024, worlds = 1024;
  study::BenchOptions options;
  bool json = false;
};

void print(const vk::Device& device, const study::Table& table, bool json, const study::Ceilings* ceilings = nullptr) {
  if (json) {
    nlohmann::ordered_json report{{"device", device.info().name}};
    if (ceilings) report["ceilings"] = study::toJson(*ceilings);
    report[table.name] = study::toJson(table);
    fmt::print("{}\n", report.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}{}\n{}", printable(device.info().name), ceilings ? ": " + study::toText(*ceilings) : "",
               study::toText(table));
  }
}

void runRaster(BenchArguments& a) {
  const std::optional<uint64_t> most = scene::parseCount(a.most);
  if (!most || *most == 0) badUsage("--most takes a number of triangles, as in 500k or 10M, not \"{}\"", a.most);
  if (*most < study::minRasterTriangles())
    badUsage("--most must be at least {}, the number of triangles of the smallest case, not \"{}\"",
             study::minRasterTriangles(), a.most);
  a.options.maxTriangles = *most;
  vk::avoidFullDriverCache();
  vk::Device device({.selector = a.render.device});
  print(device, study::benchRaster(device, a.options), a.json);
}

UnsupportedOptions unsupportedByBench(bool supportsAovs) {
  return supportsAovs ? UnsupportedOptions({"json", "aov"}, {"frames"}) : UnsupportedOptions({"json"}, {"frames"});
}

// Rejects sequences and options of outputs, except --aov for benchmarks that render what it names.
void refuseOutputs(const RenderOptions& o, bool supportsAovs = false) {
  if (const auto name = unsupportedByBench(supportsAovs).findIn(o))
    badUsage("bench measures one instant and writes no outputs: omit {}", *name);
}

// Checks the options of a benchmark with a scene, and opens its device.
template <typename Measure>
void onDevice(RenderOptions& o, const Measure& measure) {
  checkOptions(o);
  checkTime(o);
  vk::avoidFullDriverCache();
  vk::Device device({.selector = o.device, .validation = o.validate});
  measure(device);
  for (const std::string& message : device.validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

// Creates the renderer, camera and scene state.
template <typename Measure>
void inScene(vk::Device& device, RenderOptions& o, const std::string& name, const Measure& measure) {
  const scene::Scene scene = scene::load(name, loadOptions(o));
  const Timeline timeline(scene, o);
  const scene::Camera camera = timeline.cameraAt(timeline.first());
  const std::optional<scene::Environment> environment = render::loadEnvironment(scene, environmentOf(o, scene));
  render::Renderer renderer(device, scene, environment ? &*environment : nullptr);
  measure(renderer, scene, camera, timeline.momentAt(timeline.first()));
}

void runFrame(BenchArguments& a) {
  refuseOutputs(a.render);
  a.render.settings.display = true;
  onDevice(a.render, [&](vk::Device& device) {
    inScene(device, a.render, a.render.scene,
            [&](auto& renderer, const auto& scene, const auto& camera, const auto& moment) {
              const study::Ceilings ceilings = study::measureCeilings(device, a.options.frames);
              print(device, study::benchFrame(device, renderer, camera, moment, a.render.settings, ceilings, a.options),
                    a.render.json, &ceilings);
            });
  });
}

void runRays(BenchArguments& a) {
  RenderOptions& o = a.render;
  refuseOutputs(o);
  const std::optional<uint64_t> rays = scene::parseCount(a.rays);
  constexpr uint32_t kMaxRays = 64'000'000;
  if (!rays || *rays == 0 || *rays > kMaxRays)
    badUsage("--rays requires a number of rays up to 64M, as in 500k or 4M, not \"{}\"", a.rays);
  onDevice(o, [&](vk::Device& device) {
    inScene(device, o, o.scene, [&](auto& renderer, const auto&, const auto& camera, const auto& moment) {
      print(device, study::benchRays(renderer, camera, moment, o.settings, static_cast<uint32_t>(*rays), a.options),
            o.json);
    });
  });
}

// Both benchmarks compare lighting with its lower bound, which supports one sample per pixel.
void refuseSamples(const RenderOptions& o) {
  if (o.isExplicit("aa")) badUsage("bench lights and bench shade light each pixel once: omit --aa");
}

// Checks the scene's possible numbers of lights before anything is measured.
void checkLights(const std::string& scene, const std::vector<uint64_t>& counts) {
  if (!scene.starts_with("builtin:"))
    badUsage(
        "bench lights requires a built-in scene with a variable number of lights, such as builtin:hall, not \"{}\"",
        scene);
  if (scene.find(",lights=") != std::string::npos)
    badUsage("bench lights sets the number of lights itself: omit lights= from the scene, and use --lights");
  for (const scene::Builtin& builtin : scene::builtins()) {
    if (scene.substr(8, scene.find(',') - 8) != builtin.name) continue;
    const auto range = std::ranges::find(builtin.parameters, "lights", &scene::BuiltinParameter::key);
    if (range == builtin.parameters.end())
      badUsage("builtin:{} has a fixed number of lights: use builtin:hall for bench lights", builtin.name);
    for (const uint64_t count : counts)
      if (count < range->least || count > range->most)
        badUsage("builtin:{} can have {} to {} lights, not {}: change --lights", builtin.name, range->least,
                 range->most, count);
  }
}

void runLights(BenchArguments& a) {
  RenderOptions& o = a.render;
  refuseOutputs(o);
  refuseSamples(o);
  if (o.isExplicit("lighting")) badUsage("bench lights measures every technique that runs in compute: omit --lighting");
  checkBudget(a.options.budget);
  std::vector<uint64_t> counts = parseCounts("--lights", a.lights);
  checkLights(o.scene, counts);
  std::ranges::sort(counts);
  onDevice(o, [&](vk::Device& device) {
    std::optional<study::LightsBench> bench;
    for (const uint64_t lights : counts)
      inScene(device, o, fmt::format("{},lights={}", o.scene, lights),
              [&](auto& renderer, const auto& scene, const auto& camera, const auto& moment) {
                if (!bench) bench.emplace(study::measureCeilings(device, a.options.frames), a.options);
                bench->add(renderer, camera, moment, o.settings, lights);
              });
    print(device, bench->table(), o.json, &bench->ceilings());
  });
}

void runShade(BenchArguments& a) {
  RenderOptions& o = a.render;
  refuseOutputs(o);
  refuseSamples(o);
  if (o.isExplicit("shading")) badUsage("bench shade measures every reflection model: omit --shading");
  if (o.settings.lighting->draws)
    badUsage("bench shade requires a technique that runs in compute, unlike {}: choose another --lighting",
             o.settings.lighting->name);
  onDevice(o, [&](vk::Device& device) {
    inScene(device, o, o.scene, [&](auto& renderer, const auto& scene, const auto& camera, const auto& moment) {
      const study::Ceilings ceilings = study::measureCeilings(device, a.options.frames);
      print(device, study::benchShade(renderer, camera, moment, o.settings, ceilings, a.options), o.json, &ceilings);
    });
  });
}

// Measures many views, each with a world of its own if `inWorlds`.
void runViews(BenchArguments& a, bool inWorlds) {
  RenderOptions& o = a.render;
  refuseOutputs(o, true);
  if (!o.aovs.empty()) o.settings.aovs = output::parseAovs(o.aovs);
  o.settings.display = o.aovs.empty();
  onDevice(o, [&](vk::Device& device) {
    inScene(device, o, o.scene, [&](auto& renderer, const auto& scene, const auto& camera, const auto& moment) {
      print(device,
            inWorlds
                ? study::benchWorlds(device, renderer, scene, camera, moment.poses, o.settings, a.worlds, a.options)
                : study::benchViews(device, renderer, scene, camera, moment.poses, o.settings, a.views, a.options),
            o.json);
    });
  });
}

void addMeasuredOptions(CLI::App& command, RenderOptions& o, bool supportsAovs = false) {
  addRenderOptions(command, o);
  unsupportedByBench(supportsAovs).hide(command);
}

}  // namespace

void addBenchCommand(CLI::App& app) {
  auto arguments = std::make_shared<BenchArguments>();
  BenchArguments& a = *arguments;
  CLI::App* bench = app.add_subcommand(
      "bench", "Measure performance: rasterization, the passes of a frame, many views or worlds, rays, or lighting");
  bench->require_subcommand(0, 1);  // the callback's message is better than "a subcommand is required"
  bench->callback([bench] {
    if (bench->get_subcommands().empty())
      badUsage("bench requires a subject: raster, frame, views, worlds, rays, lights or shade");
  });
  CLI::App* raster = bench->add_subcommand("raster", "Random triangles by number and size, with both rasters");
  raster->add_option("--most", a.most, "Skip cases with more triangles")->capture_default_str();
  raster
      ->add_option("--device", a.render.device,
                   "Device: auto, cpu, cuda:N, a number, a name or a UUID (see latelight devices)")
      ->capture_default_str();
  raster->callback([arguments] { runRaster(*arguments); });
  CLI::App* frame = bench->add_subcommand("frame", "The passes of a frame, with the options of render");
  addMeasuredOptions(*frame, a.render);
  frame->callback([arguments] { runFrame(*arguments); });
  CLI::App* views =
      bench->add_subcommand("views", "Many views per call, left on the device, with the options of render");
  addMeasuredOptions(*views, a.render, true);
  views->add_option("--views", a.views, "Number of views")->check(CLI::Range(1, 100'000))->capture_default_str();
  views->callback([arguments] { runViews(*arguments, false); });
  CLI::App* worlds =
      bench->add_subcommand("worlds", "Many worlds per call with new transforms each, with the options of render");
  addMeasuredOptions(*worlds, a.render, true);
  worlds->add_option("--worlds", a.worlds, "Number of worlds")->check(CLI::Range(1, 100'000))->capture_default_str();
  worlds->callback([arguments] { runViews(*arguments, true); });
  CLI::App* rays = bench->add_subcommand("rays", "Rays through a scene, with the options of render");
  addMeasuredOptions(*rays, a.render);
  rays->add_option("--rays", a.rays, "Number of rays of each kind")->capture_default_str();
  rays->callback([arguments] { runRays(*arguments); });
  CLI::App* lights = bench->add_subcommand(
      "lights", "Techniques that light in compute, by number of lights, with the options of render");
  addMeasuredOptions(*lights, a.render);
  lights->add_option("--lights", a.lights, "Comma-separated numbers of lights")->capture_default_str();
  lights->add_option("--budget", a.options.budget, "Skip cases that would take longer than this many seconds")
      ->capture_default_str();
  lights->callback([arguments] { runLights(*arguments); });
  CLI::App* shade = bench->add_subcommand(
      "shade", "Lower bound for the cost of a light, compared with --lighting, with the options of render");
  addMeasuredOptions(*shade, a.render);
  shade->callback([arguments] { runShade(*arguments); });
  for (CLI::App* command : {raster, frame, views, worlds, rays, lights, shade}) {
    command->add_option("--runs", a.options.frames, "Number of measured frames")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command
        ->add_option_function<std::string>(
            "--shaders", [](const std::string& folder) { vk::useShadersOf(folder); },
            "Folder of SPIR-V files, such as build/release/spirv, that replace the embedded shaders")
        ->type_name("FOLDER");
  }
  raster->add_flag("--json", a.json, "Print JSON");
}

}  // namespace latelight::app
