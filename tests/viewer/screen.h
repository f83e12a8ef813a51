// A separate display for the test (Xvfb), its pixels, and control of its pointer and keys (xdotool).
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "app/folder.h"
#include "output/aov.h"

namespace latelight::app {

class Screen {
 public:
  // Throws std::runtime_error if Xvfb or xdotool does not exist.
  Screen(uint32_t width, uint32_t height);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  const std::string& name() const { return name_; }                                 // for DISPLAY
  void act(std::vector<std::string> words) const;                                   // runs xdotool
  output::Picture pixels(uint32_t width, uint32_t height, uint32_t top = 0) const;  // from the left, alpha 255
  void stop();                                                                      // it is gone for all who use it

 private:
  Folder folder_;
  std::string name_;
  pid_t server_ = -1;
};

}  // namespace latelight::app
