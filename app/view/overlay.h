// The overlay of the image: the slider of a split, the handles of lights, and the crosshair that keys move.
#pragma once

#include <imgui/imgui.h>

#include <optional>
#include <string>

#include "app/view/panel.h"
#include "view/state.h"

namespace latelight::app {

// The position of the image, in pixels of the window.
struct PictureArea {
  ImVec2 from, size;
  float scale = 1;  // scale of text and handles
  ImVec2 inside(ImVec2 p) const { return {p.x - from.x, p.y - from.y}; }
};

class Overlay {
 public:
  void draw(const view::State& state, const PictureArea& area, bool handles) const;
  // Each returns true if it consumed the input, which then must not move the camera.
  bool press(const view::State& state, const PictureArea& area, ImVec2 at, bool handles);
  bool move(const view::State& state, const PictureArea& area, ImVec2 at, const Send& send) const;
  bool release();
  // Tab selects the handle of the next light, and arrow keys move it.
  bool key(const view::State& state, const PictureArea& area, const std::string& name, bool shift, const Send& send);

 private:
  void drawHandles(const view::State& state, const PictureArea& area) const;

  enum class Held { Nothing, Slider, Light } held_ = Held::Nothing;
  uint32_t light_ = 0;
  std::optional<uint32_t> chosen_;  // the light that keys move
};

}  // namespace latelight::app
