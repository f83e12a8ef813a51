// The display that windows are on.
#pragma once

namespace latelight::app {

// GLFW, while any window may be open. Throws Error(NoDevice) where there is no display. A display that is lost later
// ends the program with that code and a sentence.
class Display {
 public:
  Display();
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
};

}  // namespace latelight::app
