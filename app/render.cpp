// latelight render: a scene file in, pictures and per-pixel data out.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "app/render_metadata.h"
#include "app/render_options.h"
#include "app/render_pick.h"
#include "app/render_time.h"
#include "base/files.h"
#include "base/log.h"
#include "base/parallel.h"
#include "output/debug.h"
#include "output/files.h"
#include "output/targets.h"
#include "render/renderer.h"
#include "render/session.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

struct Times {  // seconds
  double load = 0, upload = 0, render = 0, write = 0, total = 0;
};

Json describeShadings(const render::ShadingCounts& counts) {
  const auto share = [&](uint64_t count, uint64_t of) {
    return of ? static_cast<double>(count) / static_cast<double>(of) : 0.0;
  };
  return {{"pixels", counts.pixels},
          {"drawn", counts.drawn},
          {"perSample", share(counts.several, counts.drawn)},  // share of the drawn pixels
          {"shadingsAPixel", share(counts.shadings, counts.drawn)}};
}

void printReport(const scene::Scene& scene, const vk::Device& device, const render::Renderer& renderer,
                 const std::vector<std::filesystem::path>& files, const std::vector<render::Picked>& picked,
                 const Times& times) {
  Json passes = Json::array();
  for (const graph::PassTime& pass : renderer.times())
    passes.push_back({{"pass", pass.name}, {"milliseconds", pass.milliseconds}});
  Json names = Json::array();
  for (const auto& file : files) names.push_back(file.string());
  Json report{{"files", names},
              {"scene", scene.source},
              {"triangles", scene.triangleCount()},
              {"lights", scene.lights.size()},
              {"device", device.info().name},
              {"seconds",
               {{"load", times.load},
                {"upload", times.upload},
                {"render", times.render},
                {"write", times.write},
                {"total", times.total}}},
              {"gpu", passes}};
  if (!picked.empty()) report["picked"] = describePicked(picked);
  if (const auto& counts = renderer.shadingCounts()) report["shading"] = describeShadings(*counts);
  fmt::print("{}\n", report.dump(2));
}

// Writes the pictures of --debug: one, or a labelled sheet of several.
std::vector<std::filesystem::path> writeDebug(const DebugRequest& debug, const output::FrameOutput& frame,
                                              const output::Metadata& metadata, const std::string& out) {
  const auto ids = std::find_if(frame.aovs.begin(), frame.aovs.end(),
                                [](const output::AovImage& aov) { return aov.aov == output::Aov::Id; });
  std::vector<output::Labelled> pictures;
  for (const output::AovImage& aov : frame.aovs) {
    if (!output::contains(debug.aovs, aov.aov)) continue;
    output::Picture picture = aov.aov == output::Aov::Color && !frame.display.empty()
                                  ? output::Picture{frame.width, frame.height, frame.display}
                                  : output::debugPicture(aov, ids == frame.aovs.end() ? nullptr : &*ids);
    pictures.push_back({std::string(output::info(aov.aov).name), std::move(picture)});
  }
  const std::filesystem::path path =
      output::fillPattern(out, debug.sheet ? "sheet" : output::info(debug.aovs.front()).name, metadata);
  output::writePicture(path, debug.sheet ? output::contactSheet(pictures) : pictures.front().picture);
  if (out == "-") return {};
  return {path};
}

// Writes the picture of --debug targets.
std::vector<std::filesystem::path> writeTargets(const output::RawGbuffer& gbuffer, const output::Metadata& metadata,
                                                const std::string& out) {
  const std::filesystem::path path = output::fillPattern(out, "targets", metadata);
  output::writePicture(path, output::contactSheet(output::targetPictures(gbuffer)));
  if (out == "-") return {};
  return {path};
}

// Each may fill standard output once.
void checkStandardOutput(const RenderOptions& o) {
  const bool picksAsText = !o.picks.empty() && !o.json;
  if ((o.out == "-") + (o.graph == "-") + o.json + picksAsText > 1)
    badUsage("-o -, --dump-graph -, --json and --pick without --json each fill standard output; use one of them");
}

// What leaves, checked before anything costs time; and what has to be rendered for it.
output::OutputRequest planOutput(RenderOptions& o, const std::optional<DebugRequest>& debug) {
  output::OutputRequest request{.pattern = o.out};
  if (!o.aovs.empty()) request.aovs = output::parseAovs(o.aovs);
  if (o.noSideFile) request.sideFile = false;
  if (debug && !o.aovs.empty()) badUsage("--debug and --aov each say what leaves; use one of them");
  if (debug && o.out != "-" && output::formatOf(o.out) != output::Format::Png)
    badUsage("--debug writes PNG; give -o a name that ends in .png");
  if (o.out.empty() && (o.picks.empty() || debug || !o.aovs.empty()))
    badUsage("--out is required: -o says where the picture goes, unless nothing but --pick is asked for");
  checkStandardOutput(o);
  if (!o.graph.empty()) output::checkWritable(o.graph);
  if (o.out.empty()) return request;
  output::checkOutput(request);

  render::Settings& s = o.settings;
  s.countSurfaces = o.json;
  s.aovs = debug ? debug->aovs : request.aovs;
  s.display = debug ? output::contains(debug->aovs, output::Aov::Color) : output::usesDisplay(request);
  if (s.display && !debug) std::erase(s.aovs, output::Aov::Color);
  if (debug && !debug->targets && !output::contains(s.aovs, output::Aov::Id))
    s.aovs.push_back(output::Aov::Id);  // what is background
  return request;
}

// What the frames of one run share.
struct Run {
  const RenderOptions& options;
  const std::optional<DebugRequest>& debug;
  const output::OutputRequest& request;
  const scene::Scene& scene;
  const Timeline& timeline;
  const std::string& environment;  // its name
  vk::Device& device;
  render::Renderer& renderer;
  Times times{};
  std::vector<std::filesystem::path> files{};
  std::vector<render::Picked> picked{};
};

struct RenderedFrame {
  output::FrameOutput picture;
  output::RawGbuffer targets;  // instead, for --debug targets
  output::Metadata metadata;
};

RenderedFrame renderFrame(Run& run, uint32_t frame) {
  const auto mark = Clock::now();
  const scene::Camera camera = run.timeline.cameraAt(frame);
  const render::Moment moment = run.timeline.momentAt(frame);
  RenderedFrame rendered;
  if (!run.options.pixels.empty())
    run.picked = render::pick(run.renderer, run.scene, camera, run.options.settings, run.options.pixels, moment);
  if (run.debug && run.debug->targets)
    rendered.targets = run.renderer.readTargets(camera, run.options.settings, moment);
  else if (!run.options.out.empty())
    rendered.picture = std::move(run.renderer.render(std::span(&camera, 1), run.options.settings, moment).front());
  RenderOptions shown = run.options;
  shown.frame = frame;
  shown.time = run.timeline.secondsAt(frame);
  rendered.metadata = describeRender(run.scene, camera, run.device, run.environment, shown);
  rendered.metadata.frameDigits = run.timeline.frameDigits();
  run.times.render += seconds(mark);
  return rendered;
}

void writeFrame(Run& run, const RenderedFrame& frame) {
  const auto mark = Clock::now();
  std::vector<std::filesystem::path> files;
  if (run.debug && run.debug->targets)
    files = writeTargets(frame.targets, frame.metadata, run.options.out);
  else if (!run.options.out.empty())
    files = run.debug ? writeDebug(*run.debug, frame.picture, frame.metadata, run.options.out)
                      : output::writeOutput(run.request, frame.picture, frame.metadata);
  run.files.insert(run.files.end(), files.begin(), files.end());
  run.times.write += seconds(mark);
}

// Frames that can't be written don't keep the others from it.
void renderSequence(Run& run) {
  uint32_t failed = 0;
  std::string first;
  for (uint32_t frame = run.timeline.first(); frame <= run.timeline.last(); ++frame) {
    const RenderedFrame rendered = renderFrame(run, frame);
    try {
      writeFrame(run, rendered);
    } catch (const Error& error) {
      if (failed++ == 0) first = fmt::format("frame {}: {}", frame, error.what());
    }
  }
  if (failed > 0)
    fail(ExitCode::SomeFramesFailed, "{} of {} frames were not written; {}", failed,
         run.timeline.last() - run.timeline.first() + 1, first);
}

void render(RenderOptions& o) {
  const auto start = Clock::now();
  parseSettings(o);
  checkTime(o);
  const std::optional<DebugRequest> debug = parseDebug(o.debug, o.time || !o.frames.empty() || o.turn != 0);
  const output::OutputRequest request = planOutput(o, debug);

  // The device starts while the scene loads: they share nothing.
  auto deviceStart = inBackground(
      [&] { return std::make_unique<vk::Device>(vk::DeviceOptions{.selector = o.device, .validation = o.validate}); });
  const scene::Scene scene = scene::load(o.scene, {.variant = o.variant, .allowOutside = o.allowOutside});
  const Timeline timeline(scene, o);
  timeline.cameraAt(timeline.first());  // what is wrong with it shows before all else
  // A background to show is a reason for an environment, lights or not.
  const std::string asked = o.hdri.empty() && o.background == "hdri" ? "studio" : o.hdri;
  const std::string environmentName = render::environmentName(scene, asked);
  const std::optional<scene::Environment> environment = render::loadEnvironment(environmentName);
  const double loaded = seconds(start);

  const std::unique_ptr<vk::Device> device = deviceStart.get();
  const auto mark = Clock::now();
  render::Renderer renderer(*device, scene, environment ? &*environment : nullptr);
  Run run{o, debug, request, scene, timeline, environmentName, *device, renderer};
  run.times.load = loaded;
  run.times.upload = seconds(mark);

  if (timeline.isSequence())
    renderSequence(run);
  else
    writeFrame(run, renderFrame(run, timeline.first()));
  if (!o.graph.empty()) writeFile(o.graph, std::as_bytes(std::span(renderer.graphviz())));
  run.times.total = seconds(start);

  if (o.json) printReport(scene, *device, renderer, run.files, run.picked, run.times);
  if (!o.json) printPicked(run.picked, scene.yUp && !o.settings.zUp ? "gltf" : "z-up", o.normalFrame);
  for (const std::string& message : device->validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

}  // namespace

void addRenderCommand(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "Render a scene to pictures and per-pixel data");
  addRenderOptions(*command, *options);
  command->callback([options, command] {
    options->normalsChosen = command->count("--normals") > 0;
    options->positionChosen = command->count("--position") > 0;
    options->frameChosen = command->count("--frame") > 0;
    render(*options);
  });
}

}  // namespace latelight::app
