#include "app/view/windows.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "app/view/display.h"
#include "app/view/window.h"

namespace latelight::app {

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
