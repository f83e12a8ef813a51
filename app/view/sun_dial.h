// The sun's handle, on a dial in the image's lower left corner. Its direction from the center is the azimuth, 0 at the
// top and 90 at the right. At the center the sun is overhead, and at the rim it is on the horizon.
#pragma once

#include <imgui/imgui.h>

#include <functional>
#include <string>

#include "app/view/overlay.h"

namespace latelight::app {

class SunDial {
 public:
  // `set` is called with the text of the option.
  using Set = std::function<void(const std::string& sun)>;

  void draw(const std::string& sun, const PictureArea& area) const;
  // Each returns true if the dial consumed the input.
  bool press(const std::string& sun, const PictureArea& area, ImVec2 at, const Set& set);
  bool move(const std::string& sun, const PictureArea& area, ImVec2 at, const Set& set) const;
  bool release();

 private:
  bool held_ = false;
};

}  // namespace latelight::app
