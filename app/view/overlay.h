// What lies over the picture: the slider of a split, the handles of lights, and the crosshair that keys move.
#pragma once

#include <imgui/imgui.h>

#include <optional>
#include <string>

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
  // Tab chooses a light's handle, one after the other, and arrows move it.
  bool key(const view::State& state, const PictureArea& area, const std::string& name, bool shift, const Send& send);

 private:
  void drawHandles(const view::State& state, const PictureArea& area) const;

  enum class Held { Nothing, Slider, Light } held_ = Held::Nothing;
  uint32_t light_ = 0;
  std::optional<uint32_t> chosen_;  // the light that keys move
};

}  // namespace latelight::app
