// The connection to the display on which windows are shown.
#pragma once

namespace latelight::app {

// Owns GLFW while any window may be open. Throws Error(NoDevice) if there is no display. If the display is lost later,
// the program ends with that exit code and a message.
class Display {
 public:
  Display();
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
};

}  // namespace latelight::app
