// latelight bench: times of the device, pass by pass, with the rasters in turn.
#include "study/bench.h"

#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/render_options.h"
#include "app/render_run.h"
#include "base/log.h"
#include "render/session.h"
#include "scene/builtin.h"
#include "vk/driver_cache.h"

namespace latelight::app {

namespace {

struct BenchArguments {
  RenderOptions render;
  std::string most = "10M";
  uint32_t views = 1024;
  study::BenchOptions options;
  bool json = false;
};

void print(const vk::Device& device, const study::Table& table, bool json) {
  if (json) {
    const nlohmann::ordered_json report{{"device", device.info().name}, {table.name, study::toJson(table)}};
    fmt::print("{}\n", report.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else {
    fmt::print("{}\n{}", printable(device.info().name), study::toText(table));
  }
}

void runRaster(BenchArguments& a) {
  const std::optional<uint64_t> most = scene::parseCount(a.most);
  if (!most || *most == 0) badUsage("--most takes a number of triangles, as in 500k or 10M, not \"{}\"", a.most);
  a.options.mostTriangles = *most;
  vk::avoidFullDriverCache();
  vk::Device device({.selector = a.render.device});
  print(device, study::benchRaster(device, a.options), a.json);
}

// What `frame` and `views` share: a scene's renderer and camera.
template <typename Measure>
void runScene(BenchArguments& a, const Measure& measure) {
  RenderOptions& o = a.render;
  if (o.isGiven("out")) badUsage("bench measures, and writes no picture: leave -o out");
  if (o.isGiven("raster")) badUsage("bench measures both rasters: leave --raster out");
  checkOptions(o);
  checkTime(o);
  const scene::Scene scene =
      scene::load(o.scene, {.variant = o.variant, .allowOutside = o.allowOutside, .ids = o.idGrouping});
  const Timeline timeline(scene, o);
  const scene::Camera camera = timeline.cameraAt(timeline.first());
  const std::optional<scene::Environment> environment = render::loadEnvironment(environmentOf(o, scene));
  vk::avoidFullDriverCache();
  vk::Device device({.selector = o.device, .validation = o.validate});
  render::Renderer renderer(device, scene, environment ? &*environment : nullptr);
  print(device, measure(renderer, camera, timeline.momentAt(timeline.first())), o.json);
  for (const std::string& message : device.validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

void runFrame(BenchArguments& a) {
  runScene(a, [&](render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment) {
    a.render.settings.display = true;
    return study::benchFrame(renderer, camera, moment, a.render.settings, a.options);
  });
}

void runViews(BenchArguments& a) {
  runScene(a, [&](render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment) {
    if (!a.render.aovs.empty()) a.render.settings.aovs = output::parseAovs(a.render.aovs);
    a.render.settings.display = a.render.aovs.empty();
    return study::benchViews(renderer, camera, moment.poses, a.render.settings, a.views, a.options);
  });
}

}  // namespace

void addBenchCommand(CLI::App& app) {
  auto arguments = std::make_shared<BenchArguments>();
  BenchArguments& a = *arguments;
  CLI::App* bench =
      app.add_subcommand("bench", "Measure the device: rasterization, a frame pass by pass, or many views");
  bench->require_subcommand(0, 1);  // none is said below, in better words than "a subcommand is required"
  bench->callback([bench] {
    if (bench->get_subcommands().empty()) badUsage("bench takes what it measures: raster, frame or views");
  });
  CLI::App* raster = bench->add_subcommand("raster", "Random triangles, by number and size, with both rasters");
  raster->add_option("--most", a.most, "Leave out what has more triangles")->capture_default_str();
  raster->add_option("--device", a.render.device, "auto, cpu, a number, a name or a UUID (latelight devices)")
      ->capture_default_str();
  raster->callback([arguments] { runRaster(*arguments); });
  CLI::App* frame = bench->add_subcommand("frame", "A frame to its picture on the device; takes the options of render");
  addRenderOptions(*frame, a.render);
  frame->callback([arguments] { runFrame(*arguments); });
  CLI::App* views =
      bench->add_subcommand("views", "Many views at once, left on the device; takes the options of render");
  addRenderOptions(*views, a.render);
  views->add_option("--views", a.views, "How many")->check(CLI::Range(1, 100'000))->capture_default_str();
  views->callback([arguments] { runViews(*arguments); });
  for (CLI::App* command : {raster, frame, views})
    command->add_option("--runs", a.options.frames, "Frames of each measurement")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
  raster->add_flag("--json", a.json, "The table as JSON");
}

}  // namespace latelight::app
