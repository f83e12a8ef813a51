// `latelight report`: compares a scene in every layout and by every technique on one page for a browser.
#include <fmt/core.h>

#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/explicit_options.h"
#include "app/parse.h"
#include "app/render_options.h"
#include "app/render_run.h"
#include "base/files.h"
#include "output/used_files.h"
#include "render/submit/raster_choice.h"
#include "render/submit/session.h"
#include "report/command.h"
#include "report/scene_page.h"
#include "scene/load/load.h"
#include "vk/driver_cache.h"

namespace latelight::app {

namespace {

constexpr uint32_t kWidth = 288, kHeight = 162;  // if --size is not given
constexpr size_t kMaxBytes = 20'000'000;         // limit for a page, so that it opens at once and can be sent to others

struct ReportArguments {
  RenderOptions render;
  uint32_t runs = 4;
  const CLI::App* command = nullptr;
};

// These have no effect on a page, which has no data outputs and one instant, or replace what it compares.
UnsupportedOptions unsupportedByReport() {
  return {{"out"}, {"frames", "axes", "normal-frame", "data-surfaces", "position-origin", "lens"}};
}

// Rejects options that a page does not support or varies itself.
void checkGiven(const RenderOptions& o) {
  if (!o.lens.empty())
    badUsage(
        "report compares layouts, and cameras whose lens bends rays are rendered with one layout only: omit --lens");
  if (const auto name = unsupportedByReport().findIn(o))
    badUsage("report selects its own images and values: omit {}", *name);
  if (o.out.empty()) badUsage("--out is required: give the output file, for example -o report.html");
  checkPageName("report", o.out);
  checkWritable(o.out);
}

// Rejects --fps if no target of a layout can store motion.
void checkMotion(const RenderOptions& o, const scene::Scene& scene) {
  const bool moves = (o.settings.time && scene.rig.isAnimated()) || o.turn != 0;
  if (o.isExplicit("fps") && !moves) badUsage("report has no motion for --fps: omit it, or use --time or --turn");
}

// Returns the scene and the given options, except these. The size is always included, because the default sizes of a
// page and of an image differ.
std::vector<std::string> wordsOf(const ReportArguments& a, std::vector<std::string_view> but) {
  but.insert(but.end(), {"out", "validate", "size", "runs"});
  std::vector<std::string> words = report::joined({a.render.scene}, explicitOptions(*a.command, but));
  words.insert(words.end(), {"--size", fmt::format("{}x{}", a.render.settings.width, a.render.settings.height)});
  return words;
}

// Returns the command that creates the page.
std::string ownCommand(const ReportArguments& a) {
  std::vector<std::string> words = report::joined({"report"}, wordsOf(a, {}));
  words.insert(words.end(), {"--runs", fmt::format("{}", a.runs), "-o", a.render.out});
  return report::commandLine(words);
}

std::string makePage(ReportArguments& a, vk::Device& device, const scene::Scene& scene, const Timeline& timeline) {
  RenderOptions& o = a.render;
  o.settings.raster = render::chooseRaster(device, o.settings, scene).raster;
  const std::optional<scene::Environment> environment = render::loadEnvironment(scene, environmentOf(o, scene));
  render::Renderer renderer(device, scene, environment ? &*environment : nullptr);
  const scene::Camera camera = timeline.cameraAt(timeline.first());
  const render::SceneState moment = timeline.momentAt(timeline.first());
  study::Options normals{.device = o.device, .validation = o.validate};
  return report::scenePage({device, renderer, scene, camera, moment, o.settings,
                            wordsOf(a, {"layout", "lighting", "raster"}), ownCommand(a), normals, a.runs, kMaxBytes});
}

void run(ReportArguments& a) {
  RenderOptions& o = a.render;
  checkGiven(o);
  checkOptions(o);
  checkTime(o);
  vk::avoidFullDriverCache();
  const scene::Scene scene = scene::load(o.scene, loadOptions(o));
  checkMotion(o, scene);
  std::vector<std::filesystem::path> inputs = scene.files;
  if (const std::string environment = environmentOf(o, scene); !environment.empty()) inputs.emplace_back(environment);
  output::UsedFiles(inputs).checkOutputs(std::vector<std::filesystem::path>{o.out});
  const Timeline timeline(scene, o);
  vk::Device device({.selector = o.device, .validation = o.validate});
  const std::string page = makePage(a, device, scene, timeline);
  for (const std::string& message : device.validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
  writeFile(o.out, std::as_bytes(std::span(page)));
}

}  // namespace

void addReportCommand(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  ReportArguments& a = *arguments;
  a.render.settings.width = kWidth, a.render.settings.height = kHeight;
  CLI::App* command = app.add_subcommand(
      "report", "Write a page with a scene in every layout and with every technique, with the options of render");
  addRenderOptions(*command, a.render);
  unsupportedByReport().hide(*command);
  optionOf(*command, "size").default_str(fmt::format("{}x{}", kWidth, kHeight));
  optionOf(*command, "out").description("Self-contained HTML page; - is standard output");
  command->add_option("--runs", a.runs, "Number of frames for the median times")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  a.command = command;
  command->callback([arguments] { run(*arguments); });
}

}  // namespace latelight::app
