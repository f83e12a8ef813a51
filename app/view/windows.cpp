#include "app/view/windows.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "app/view/window.h"
#include "base/error.h"

namespace latelight::app {

namespace {

// GLFW, while any window may be open.
struct Display {
  Display() {
    if (glfwInit()) return;
    fail(ExitCode::NoDevice,
         "there is no display to open a window on: `latelight render` writes pictures without one, and `latelight "
         "serve` shows them in a browser");
  }
  ~Display() { glfwTerminate(); }
};

}  // namespace

void showWindows(const view::Start& start) {
  const Display display;
  std::vector<std::unique_ptr<Window>> windows;
  windows.push_back(std::make_unique<Window>(start));
  while (!windows.empty()) {
    const bool busy = std::ranges::any_of(windows, [](const auto& window) { return window->wantsDrawing(); });
    busy ? glfwPollEvents() : glfwWaitEvents();
    bool another = false;
    for (const auto& window : windows) another |= window->show();
    std::erase_if(windows, [](const auto& window) { return window->isClosed(); });
    if (another) windows.push_back(std::make_unique<Window>(start));
  }
}

}  // namespace latelight::app
