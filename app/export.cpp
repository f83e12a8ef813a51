// `latelight export`: writes a scene to a file that other programs read.
#include <filesystem>
#include <memory>

#include "app/commands.h"
#include "app/render_options.h"
#include "base/error.h"
#include "base/files.h"
#include "export/export.h"
#include "output/used_files.h"
#include "scene/load/load.h"

namespace latelight::app {

namespace {

// The options of render that affect how a scene is loaded.
constexpr std::string_view kLoadOptions[] = {"variant", "allow-outside", "unit", "up-axis", "point-radius", "memory"};

void runExport(RenderOptions& o) {
  if (o.out.empty()) badUsage("--out is required: give the output file, for example -o scene.glb");
  exports::checkExportName(o.out);
  checkOptions(o);
  checkWritable(o.out);
  const scene::Scene scene = scene::load(o.scene, loadOptions(o));
  output::UsedFiles(scene.files).checkOutputs(std::vector<std::filesystem::path>{o.out});
  exports::exportScene(scene, o.out);
}

}  // namespace

void addExportCommand(CLI::App& app) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("export", "Write a scene to a .glb, .obj or .ply file");
  for (const render::Option& option : commandOptions()) {
    const std::string_view key = render::keyOf(option);
    const bool isPositional = option.name[0] != '-';
    if (isPositional || std::ranges::find(kLoadOptions, key) != std::end(kLoadOptions))
      addCommandOption(*command, *options, option);
  }
  command->add_option("-o,--out", options->out, "Output file: .glb, or .obj or .ply for the geometry only")
      ->type_name("TEXT")
      ->group("Output");
  command->callback([options] { runExport(*options); });
}

}  // namespace latelight::app
