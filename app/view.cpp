// `latelight view`: shows a scene in windows.
#include "app/commands.h"
#include "app/view_start.h"
#include "vk/driver_cache.h"
#ifdef LATELIGHT_VIEWER
#include "app/view/windows.h"
#endif

namespace latelight::app {

namespace {

void viewScene(ViewOptions& options) {
  const view::Start start = viewStart(options, "view");
#ifdef LATELIGHT_VIEWER
  vk::avoidFullDriverCache();
  showWindows(start);
#else
  fail(ExitCode::NoDevice,
       "this program was built without the viewer (GLFW and Dear ImGui): use `latelight render` to write images, or "
       "`latelight serve` to show them in a browser");
#endif
}

}  // namespace

void addViewCommand(CLI::App& app) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand("view", "Show a scene interactively in a window");
  addViewOptions(*command, *options);
  command->callback([options] { viewScene(*options); });
}

}  // namespace latelight::app
