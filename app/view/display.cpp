#include "app/view/display.h"

#include <GLFW/glfw3.h>
#include <X11/Xlib.h>  // defines words as macros: this file is compiled by itself

#include <cstdio>
#include <cstdlib>

#include "base/error.h"

namespace latelight::app {

namespace {

// Ends the program with a message, because Xlib cannot continue and would end it after this handler returns. Other
// threads are still rendering, so nothing is destroyed.
int endWithoutDisplay(::Display*) {
  std::fputs(
      "latelight: the connection to the display was lost, and the windows with it; `latelight serve` shows the same "
      "views in a browser\n",
      stderr);
  std::_Exit(static_cast<int>(ExitCode::NoDevice));
}

}  // namespace

Display::Display() {
  if (!glfwInit())
    fail(ExitCode::NoDevice,
         "there is no display: use `latelight render` to write images, or `latelight serve` to show them in a browser");
  XSetIOErrorHandler(endWithoutDisplay);
}

Display::~Display() {
  glfwTerminate();
}

}  // namespace latelight::app
