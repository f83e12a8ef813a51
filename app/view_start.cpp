#include "app/view_start.h"

#include "app/parse.h"
#include "base/error.h"
#include "vk/shaders.h"

namespace latelight::app {

namespace {

UnsupportedOptions unsupportedByViewer() {
  return {{"debug"}, {"frames", "turn", "up", "orbit", "lens"}};
}

}  // namespace

void addViewOptions(CLI::App& command, ViewOptions& options) {
  addRenderOptions(command, options);
  unsupportedByViewer().hide(command);
  command
      .add_option(
          "--shaders", options.shaders,
          "Folder of SPIR-V, such as build/release/spirv, that takes the place of the program's own; followed when it "
          "changes")
      ->type_name("FOLDER")
      ->group("Shaders");
}

view::Start viewStart(ViewOptions& o, std::string_view command) {
  if (const auto name = unsupportedByViewer().findIn(o))
    badUsage("{} is interactive and does not support {}: omit it", command, *name);
  checkOptions(o);
  vk::useShadersOf(o.shaders);
  view::Start start{.scene = o.scene,
                    .load = loadOptions(o),
                    .device = o.device,
                    .validate = o.validate,
                    .environment = o.hdri,
                    .camera = o.camera,
                    .fov = o.fov,
                    .width = o.settings.width,
                    .height = o.settings.height};
  if (o.eye.empty() != o.target.empty()) badUsage("--eye and --target require each other");
  if (!o.eye.empty() && !o.camera.empty()) badUsage("--camera and --eye both set the camera; use one of them");
  if (o.fov && o.eye.empty()) badUsage("{} supports --fov only with --eye and --target", command);
  if (!o.eye.empty()) start.eye = parseVector("--eye", o.eye), start.target = parseVector("--target", o.target);
  if (!o.debug.empty()) start.choice.output = o.debug;
  for (const render::Option& option : render::options()) {
    const std::string key(render::keyOf(option));
    if (!o.isExplicit(key) || key == "size") continue;
    start.choice.options[key] = option.kind == render::OptionKind::Flag ? "true" : o.given.find(key)->second;
  }
  return start;
}

}  // namespace latelight::app
