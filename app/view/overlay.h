// What lies over the picture: the slider of a split, and the handles of lights.
#pragma once

#include <imgui/imgui.h>

#include <optional>

#include "app/view/panel.h"
#include "view/state.h"

namespace latelight::app {

// Where the picture is, pixels of the window.
struct PictureArea {
  ImVec2 from, size;
  float scale = 1;  // of letters, and of what is to be taken hold of
  ImVec2 inside(ImVec2 p) const { return {p.x - from.x, p.y - from.y}; }
};

class Overlay {
 public:
  void draw(const view::State& state, const PictureArea& area, bool handles) const;
  // Each says whether it was meant for something here, and not for the camera.
  bool press(const view::State& state, const PictureArea& area, ImVec2 at, bool handles);
  bool move(const view::State& state, const PictureArea& area, ImVec2 at, const Send& send) const;
  bool release();

 private:
  enum class Held { Nothing, Slider, Light } held_ = Held::Nothing;
  uint32_t light_ = 0;
};

}  // namespace latelight::app
