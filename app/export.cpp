// `latelight export`: writes a scene, or the scene of a frame of a job, to a file that other programs read.
#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "app/commands.h"
#include "app/render_options.h"
#include "base/error.h"
#include "base/files.h"
#include "base/lowercase.h"
#include "base/text.h"
#include "data/batch/frame_scene.h"
#include "export/export.h"
#include "output/used_files.h"
#include "scene/load/load.h"
#include "view/shell_words.h"

namespace latelight::app {

namespace {

// The options of render that affect how a scene is loaded.
constexpr std::string_view kLoadOptions[] = {"variant", "allow-outside", "unit", "up-axis", "point-radius", "memory"};

struct ExportArguments {
  RenderOptions options;
  std::string job, frame;
};

void exportScene(const RenderOptions& o) {
  scene::LoadOptions load = loadOptions(o);
  load.morphTargets = true;
  const scene::Scene scene = scene::load(o.scene, load);
  exports::exportScene(scene, o.out, scene.files);
}

uint64_t parseFrame(const std::string& text) {
  const std::optional<uint64_t> frame = parseNumber<uint64_t>(text);
  if (!frame) badUsage("--frame requires the index of a frame of --job, such as 0, not \"{}\"", text);
  return *frame;
}

// Prints the command that renders the frame's picture from the file.
void exportFrame(const ExportArguments& a) {
  const std::string& out = a.options.out;
  for (const auto& [key, value] : a.options.given)
    if (key != "memory")
      badUsage("--job defines the scene and how it is loaded: omit {}", key == "SCENE" ? value : "--" + key);
  const uint64_t index = parseFrame(a.frame);
  const std::vector<std::filesystem::path> own{a.job};
  output::UsedFiles(own).checkOutputs(std::vector<std::filesystem::path>{out});
  data::JobDocument document = data::readJobFile(a.job);
  if (document.json.is_object()) document.json.emplace("output", ".");  // frames do not depend on the set's folder
  const data::Job job = data::makeJob(document);
  data::FrameScene frame = data::sceneOfFrame(job, index);
  frame.files.emplace_back(a.job);
  exports::exportScene(frame.scene, out, frame.files);
  if (lowercaseExtension(out) != ".glb") return;
  std::vector<std::string> words{"latelight", "render", out, "-o",
                                 std::filesystem::path(frame.name).filename().string() + ".png"};
  words.insert(words.end(), frame.options.begin(), frame.options.end());
  fmt::print("{}\n", view::shellWords(words));
}

void runExport(ExportArguments& a) {
  RenderOptions& o = a.options;
  if (o.out.empty()) badUsage("--out is required: give the output file, for example -o scene.glb");
  if (a.job.empty() != a.frame.empty())
    badUsage("--job and --frame require each other: they name a frame of a data set");
  exports::checkExportName(o.out);
  checkOptions(o);
  checkWritable(o.out);
  if (!a.frame.empty())
    exportFrame(a);
  else
    exportScene(o);
}

}  // namespace

void addExportCommand(CLI::App& app) {
  auto arguments = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Write a scene to a .glb, .obj or .ply file");
  for (const render::Option& option : commandOptions()) {
    const std::string_view key = render::keyOf(option);
    const bool isPositional = option.name[0] != '-';
    if (isPositional || std::ranges::find(kLoadOptions, key) != std::end(kLoadOptions))
      addCommandOption(*command, arguments->options, option);
  }
  const char* group = "Frame of a data set";
  command->add_option("--job", arguments->job, "Job of latelight batch, .json or .yaml, in place of a scene")
      ->type_name("TEXT")
      ->group(group);
  command
      ->add_option("--frame", arguments->frame,
                   "Index of the frame: its scene, with the frame's variation, time and camera, is written, and the "
                   "command is printed that renders the file as the frame")
      ->type_name("INTEGER")
      ->group(group);
  command->add_option("-o,--out", arguments->options.out, "Output file: .glb, or .obj or .ply for the geometry only")
      ->type_name("TEXT")
      ->group("Output");
  command->callback([arguments] { runExport(*arguments); });
}

}  // namespace latelight::app
