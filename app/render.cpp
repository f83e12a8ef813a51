// `latelight render`: renders images and per-pixel data of a scene file.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "app/commands.h"
#include "app/render_correspond.h"
#include "app/render_heap.h"
#include "app/render_labels.h"
#include "app/render_metadata.h"
#include "app/render_pick.h"
#include "app/render_run.h"
#include "base/files.h"
#include "base/log.h"
#include "base/parallel.h"
#include "output/files.h"
#include "output/used_files.h"
#include "render/frame/view.h"
#include "render/outputs/outputs.h"
#include "render/submit/id_manifest.h"
#include "render/submit/lens_settings.h"
#include "render/submit/raster_choice.h"
#include "render/submit/renderer.h"
#include "render/submit/request.h"
#include "render/submit/session.h"
#include "scene/load/load.h"
#include "vk/driver_cache.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

Json describeShadings(const render::ShadingCounts& counts) {
  const auto share = [&](uint64_t count, uint64_t of) {
    return of ? static_cast<double>(count) / static_cast<double>(of) : 0.0;
  };
  return {{"pixels", counts.pixels},
          {"drawn", counts.drawn},
          {"perSample", share(counts.several, counts.drawn)},  // share of the drawn pixels
          {"shadingsAPixel", share(counts.shadings, counts.drawn)}};
}

Json describeExposures(const std::vector<float>& factors) {
  Json all = Json::array();
  for (const float factor : factors)
    all.push_back({{"factor", factor}, {"ev", std::log2(factor)}, {"ev100", output::ev100Of(factor)}});
  return all;
}

void printReport(const RenderRun& run) {
  const RenderTimes& times = run.times;
  Json passes = Json::array();
  for (const graph::PassTime& pass : run.statistics.passTimes)
    passes.push_back({{"pass", pass.name}, {"milliseconds", pass.milliseconds}});
  Json names = Json::array();
  for (const auto& file : run.files) names.push_back(file.string());
  Json report{{"files", names},
              {"scene", run.scene.source},
              {"triangles", run.scene.triangleCount()},
              {"lights", run.scene.lights.size()},
              {"device", run.device.info().name},
              {"seconds",
               {{"load", times.load},
                {"upload", times.upload},
                {"render", times.render},
                {"write", times.write},
                {"total", times.total}}},
              {"gpu", passes}};
  if (!run.exposures.empty()) report["exposures"] = describeExposures(run.exposures);
  if (!run.picked.empty()) report["picked"] = describePicked(run.picked);
  if (const auto& counts = run.statistics.shadingCounts) report["shading"] = describeShadings(*counts);
  // Paths and names need not be UTF-8.
  fmt::print("{}\n", report.dump(2, ' ', false, Json::error_handler_t::replace));
}

std::vector<std::filesystem::path> writeDebugPicture(const output::DebugRequest& debug, const output::Picture& picture,
                                                     const output::Metadata& metadata, const std::string& out) {
  const std::filesystem::path path = output::fillPattern(out, output::debugName(debug), metadata);
  output::makeFilledFolders(out, path);
  output::writePicture(path, picture);
  if (out == "-") return {};
  return {path};
}

// Only one of these options may write to standard output.
void checkStandardOutput(const RenderOptions& o) {
  const bool picksAsText = !o.picks.empty() && !o.json;
  if ((o.out == "-") + (o.labels == "-") + (o.graph == "-") + o.json + picksAsText > 1)
    badUsage(
        "-o -, --labels -, --dump-graph -, --json and --pick without --json all write to standard output; use one of "
        "them");
}

// Requests the frame graph for --dump-graph. Labels and correspondences are of several graphs, of which none is kept.
void planGraph(RenderOptions& o) {
  if (o.graph.empty()) return;
  if (o.out.empty() && o.picks.empty())
    badUsage("--dump-graph writes the graph of a picture or of --pick: give -o or --pick, or omit --dump-graph");
  checkWritable(o.graph);
  o.settings.describeGraph = true;
}

// Plans the outputs and the settings that they require. All checks precede any expensive work.
output::OutputRequest planOutput(RenderOptions& o, const std::optional<output::DebugRequest>& debug) {
  output::OutputRequest request{.pattern = o.out};
  if (!o.aovs.empty()) request.aovs = output::parseAovs(o.aovs);
  if (o.settings.exposure.automatic) request.sideFile = true;  // it states the exposure
  if (o.noSideFile) request.sideFile = false;
  request.inSequence = !o.frames.empty();
  if (debug && !o.aovs.empty()) badUsage("--debug and --aov both select what is written: use one of them");
  const bool isPictureOptional = !o.picks.empty() || !o.labels.empty() || !o.correspond.empty();
  if (o.out.empty() && (!isPictureOptional || debug || !o.aovs.empty()))
    badUsage("--out is required: give the output file with -o, unless only --pick, --labels or --correspond is used");
  if (debug && !output::isPngName(o.out))
    badUsage("--debug writes PNG; give -o a name that ends in .png, not \"{}\"", o.out);
  checkStandardOutput(o);
  planGraph(o);
  if (o.out.empty()) return request;
  output::checkOutput(request);

  render::Settings& s = o.settings;
  s.countSurfaces = o.json;
  if (debug) {
    render::showDebug(s, *debug);
    return request;
  }
  s.aovs = request.aovs;
  s.display = output::usesDisplay(request);
  if (s.display) std::erase(s.aovs, output::Aov::Color);
  return request;
}

// Returns the files that one frame and --dump-graph write.
std::vector<std::filesystem::path> outputsOf(const RenderOptions& o, const RenderPlan& plan,
                                             const output::Metadata& metadata) {
  std::vector<std::filesystem::path> paths;
  if (plan.debug)
    paths = {output::fillPattern(o.out, output::debugName(*plan.debug), metadata)};
  else if (!o.out.empty())
    paths = output::outputPaths(plan.request, metadata);
  if (const auto ids = plan.debug ? std::nullopt : output::idManifestPath(plan.request, metadata))
    paths.push_back(*ids);
  if (plan.labels) paths.push_back(output::fillPattern(o.labels, "", metadata));
  if (!o.correspond.empty()) paths.push_back(output::fillPattern(o.correspond, "", metadata));
  paths.emplace_back(o.graph);
  return paths;
}

// Throws Error(Usage) if a file would overwrite an input of the scene or its environment, or another output.
void checkFiles(const RenderOptions& o, const RenderPlan& plan, const scene::Scene& scene, const Timeline& timeline,
                const std::string& environment) {
  std::vector<std::filesystem::path> inputs = scene.files;
  if (!environment.empty()) inputs.emplace_back(environment);
  if (const std::filesystem::path file = keypointsFile(o); !file.empty()) inputs.push_back(file);
  output::UsedFiles used(inputs);
  output::Metadata named;
  named.scene = scene.name;
  named.camera.name = timeline.cameraAt(timeline.first()).name;
  named.frameDigits = timeline.frameDigits();
  for (uint64_t frame = timeline.first(); frame <= timeline.last(); ++frame) {
    named.frame = static_cast<uint32_t>(frame);  // the counter has 64 bits, because --frame may be the largest uint32_t
    const std::vector<std::filesystem::path> outputs = outputsOf(o, plan, named);
    used.checkOutputs(outputs);
    // In a sequence, a frame that cannot be written does not stop the others.
    if (timeline.isSequence()) continue;
    std::error_code ignored;  // writing reports the error
    for (const std::filesystem::path& path : outputs)
      if (isThere(path)) checkWritable(path);
  }
}

// A frame in flight: its ticket or, for --debug targets, the finished result.
struct PendingFrame {
  output::Metadata metadata;
  std::optional<render::Ticket> picture;
  output::RawGbuffer targets;
  Json labels;
  std::optional<labels::Correspondence> match;
};

struct RenderedFrame {
  output::FrameOutput picture;
  output::RawGbuffer targets;  // used instead for --debug targets
  output::Metadata metadata;
  Json labels;
  std::optional<labels::Correspondence> match;
};

// The frame's labels. The metadata of images need not have ids.
Json labelsOf(RenderRun& run, const scene::Camera& camera, const render::SceneState& moment,
              const output::Metadata& metadata) {
  if (!run.ids) run.ids = std::make_shared<output::IdManifest>(render::idManifest(run.scene));
  output::Metadata described = metadata;
  described.ids = run.ids;
  return labelFrame(run.renderer, run.scene, camera, run.options.settings, moment, *run.plan.labels, described);
}

labels::Correspondence correspondenceOf(RenderRun& run, uint32_t frame, const scene::Camera& camera,
                                        const scene::Pose& pose) {
  const Timeline::SecondPicture second = run.timeline.secondPicture(frame);
  return labels::correspond(run.renderer, run.scene, {camera, pose}, {second.camera, second.pose},
                            run.options.settings);
}

PendingFrame startFrame(RenderRun& run, uint32_t frame) {
  const auto mark = Clock::now();
  const scene::Camera camera = run.timeline.cameraAt(frame);
  const render::SceneState moment = run.timeline.momentAt(frame);
  PendingFrame pending;
  if (!run.options.pixels.empty()) {
    render::PickResult result =
        render::pick(run.renderer, run.scene, camera, run.options.settings, run.options.pixels, moment);
    run.picked = std::move(result.picked);
    run.statistics = std::move(result.statistics);
  }
  if (run.plan.debug && run.plan.debug->targets) {
    render::TargetsResult result = run.renderer.readTargets(camera, run.options.settings, moment);
    pending.targets = std::move(result.gbuffer);
    run.statistics = std::move(result.statistics);
  } else if (!run.options.out.empty()) {
    pending.picture = run.renderer.submit(std::span(&camera, 1), run.options.settings, moment);
  }
  RenderOptions shown = run.options;
  shown.frame = frame;
  shown.settings.time = run.timeline.secondsAt(frame);
  if (render::bendsRays(camera)) shown.settings = render::lensSettings(shown.settings);
  pending.metadata = describeRender(run.scene, camera, run.device, run.environment, shown);
  pending.metadata.frameDigits = run.timeline.frameDigits();
  if (run.plan.labels) pending.labels = labelsOf(run, camera, moment, pending.metadata);
  if (!run.options.correspond.empty()) pending.match = correspondenceOf(run, frame, camera, moment.poses.current);
  run.times.render += seconds(mark);
  return pending;
}

RenderedFrame finishFrame(RenderRun& run, PendingFrame&& pending) {
  const auto mark = Clock::now();
  RenderedFrame rendered{.targets = std::move(pending.targets),
                         .metadata = std::move(pending.metadata),
                         .labels = std::move(pending.labels),
                         .match = std::move(pending.match)};
  if (pending.picture) {
    render::RenderResult result = pending.picture->take();
    rendered.picture = std::move(result.frames.front());
    rendered.metadata.exposure = rendered.picture.exposure;
    if (rendered.metadata.metered) run.exposures.push_back(rendered.picture.exposure);
    run.statistics = std::move(result.statistics);
  }
  run.times.render += seconds(mark);
  return rendered;
}

// Writes a frame. The id manifest, which all frames share, is written with the first frame whose writing succeeds.
std::vector<std::filesystem::path> writeFiles(RenderRun& run, const RenderedFrame& frame) {
  const output::OutputRequest& request = run.plan.request;
  const auto ids = output::idManifestPath(request, frame.metadata);
  if (ids && !run.hasIdManifest) output::writeIdManifest(request, frame.metadata);
  std::vector<std::filesystem::path> files = output::writeOutput(request, frame.picture, frame.metadata);
  if (ids && !std::exchange(run.hasIdManifest, true)) files.push_back(*ids);
  return files;
}

void writeFrame(RenderRun& run, const RenderedFrame& frame) {
  const auto mark = Clock::now();
  std::vector<std::filesystem::path> files;
  if (run.plan.debug && run.plan.debug->targets)
    files = writeDebugPicture(*run.plan.debug, output::debugPicture(*run.plan.debug, frame.targets), frame.metadata,
                              run.options.out);
  else if (run.plan.debug)
    files = writeDebugPicture(*run.plan.debug, output::debugPicture(*run.plan.debug, frame.picture), frame.metadata,
                              run.options.out);
  else if (!run.options.out.empty())
    files = writeFiles(run, frame);
  if (run.plan.labels)
    for (const std::filesystem::path& file : writeLabels(run.options.labels, frame.labels, frame.metadata))
      files.push_back(file);
  if (frame.match) files.push_back(writeCorrespondence(run.options.correspond, *frame.match, frame.metadata));
  run.files.insert(run.files.end(), files.begin(), files.end());
  run.times.write += seconds(mark);
}

// Renders each frame while the previous one is written. A frame that cannot be written does not stop the others. A
// frame that cannot be rendered ends the sequence after all earlier frames are written.
void renderSequence(RenderRun& run) {
  uint32_t failed = 0;
  std::string first;
  std::optional<PendingFrame> next = startFrame(run, run.timeline.first());
  std::exception_ptr ended;
  for (uint32_t frame = run.timeline.first(); next; ++frame) {
    PendingFrame current = *std::exchange(next, std::nullopt);
    try {
      if (frame < run.timeline.last()) next = startFrame(run, frame + 1);
    } catch (...) {
      ended = std::current_exception();
    }
    const RenderedFrame rendered = finishFrame(run, std::move(current));
    try {
      writeFrame(run, rendered);
    } catch (const Error& error) {
      if (failed++ == 0) first = fmt::format("frame {}: {}", frame, error.what());
    }
  }
  if (ended) std::rethrow_exception(ended);
  if (failed > 0)
    fail(ExitCode::SomeFramesFailed, "{} of {} frames were not written; {}", failed,
         run.timeline.last() - run.timeline.first() + 1, first);
}

}  // namespace

RenderPlan planRender(RenderOptions& o) {
  checkOptions(o);
  checkTime(o);
  RenderPlan plan;
  if (!o.debug.empty()) plan.debug = output::parseDebug(o.debug, o.settings.time || !o.frames.empty() || o.turn != 0);
  plan.request = planOutput(o, plan.debug);
  plan.labels = planLabels(o);
  checkCorrespond(o);
  return plan;
}

std::string environmentOf(const RenderOptions& o, const scene::Scene& scene) {
  // Showing the background requires an environment, even if lights exist.
  return render::environmentName(scene, o.hdri, o.settings.background.kind == render::Background::Environment);
}

void renderAll(RenderRun& run) {
  const RenderOptions& o = run.options;
  const auto start = Clock::now();
  if (run.timeline.isSequence())
    renderSequence(run);
  else
    writeFrame(run, finishFrame(run, startFrame(run, run.timeline.first())));
  if (!o.graph.empty()) writeFile(o.graph, std::as_bytes(std::span(run.statistics.graphviz)));
  run.times.total += seconds(start);

  if (o.json) printReport(run);
  if (!o.json)
    printPicked(run.picked, run.scene.yUp && o.settings.axes == render::Axes::File ? "gltf" : "z-up",
                render::nameOf(o.settings.normalFrame));
  for (const std::string& message : run.device.validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

namespace {

// Returns the material slots whose textures are required. For data outputs, skipping the other textures reduces the
// load time to a fraction.
uint32_t texturesFor(const RenderOptions& o, const RenderPlan& plan) {
  if (plan.debug && plan.debug->targets) return ~0u;
  const uint32_t picked = o.picks.empty() ? 0 : 1u << shared::kTextureNormal;
  return picked | (o.out.empty() ? 0 : render::textureSlots(o.settings));
}

void render(RenderOptions& o) {
  const auto start = Clock::now();
  const RenderPlan plan = planRender(o);

  if (!o.scene.starts_with("builtin:")) reuseFreedMemory();  // for textures, which built-in scenes do not have
  vk::avoidFullDriverCache();
  // The device starts while the scene loads, because they share nothing.
  auto deviceStart = inBackground(
      [&] { return std::make_unique<vk::Device>(vk::DeviceOptions{.selector = o.device, .validation = o.validate}); });
  scene::LoadOptions load = loadOptions(o);
  load.textureSlots = texturesFor(o, plan);
  const scene::Scene scene = scene::load(o.scene, load);
  if (plan.labels) warnOfMissingNodes(*plan.labels, scene);
  const Timeline timeline(scene, o);
  timeline.cameraAt(timeline.first());  // reports errors early
  if (!o.correspond.empty()) timeline.secondPicture(timeline.first());
  const std::string environmentName = environmentOf(o, scene);
  checkFiles(o, plan, scene, timeline, environmentName);
  // Data outputs do not depend on the environment. One that the user names is loaded all the same, to report errors.
  const bool lit = render::isLit(o.settings) || (plan.debug && plan.debug->targets) || !o.hdri.empty();
  const std::optional<scene::Environment> environment =
      lit ? render::loadEnvironment(scene, environmentName) : std::nullopt;
  const double loaded = seconds(start);

  const std::unique_ptr<vk::Device> device = deviceStart.get();
  const auto mark = Clock::now();
  o.settings.raster = render::chooseRaster(*device, o.settings, scene).raster;
  render::Renderer renderer(*device, scene, environment ? &*environment : nullptr);
  RenderRun run{o, plan, scene, timeline, environmentName, *device, renderer};
  run.times.load = loaded;
  run.times.upload = seconds(mark);
  run.times.total = seconds(start);
  renderAll(run);
}

}  // namespace

void addRenderCommand(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "Render a scene to pictures and per-pixel data");
  addRenderOptions(*command, *options);
  command->callback([options] { render(*options); });
}

}  // namespace latelight::app
