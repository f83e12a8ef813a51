// The sun's handle, on a dial in the picture's lower left corner: its way from the middle is the azimuth, 0 at the top
// and 90 at the right; in the middle the sun is overhead, and at the rim on the horizon.
#pragma once

#include <imgui/imgui.h>

#include <functional>
#include <string>

#include "app/view/overlay.h"

namespace latelight::app {

class SunDial {
 public:
  // `set` is called with the option's text.
  using Set = std::function<void(const std::string& sun)>;

  void draw(const std::string& sun, const PictureArea& area) const;
  // Each says whether it was meant for the dial.
  bool press(const std::string& sun, const PictureArea& area, ImVec2 at, const Set& set);
  bool move(const std::string& sun, const PictureArea& area, ImVec2 at, const Set& set) const;
  bool release();

 private:
  bool held_ = false;
};

}  // namespace latelight::app
