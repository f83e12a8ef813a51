// Maps pointer, wheel and key input to camera movement.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "view/camera_control.h"
#include "view/input.h"

namespace latelight::view {

class Steering {
 public:
  Navigation navigation = Navigation::Orbit;

  // The size in pixels of the picture under the pointer.
  void resize(uint32_t width, uint32_t height);

  // Each returns true if the input moves the camera.
  bool moves(const PointerMove& move) const;
  bool moves(const Key& key) const;

  void pointer(const PointerMove& move, CameraControl* camera);  // `camera` is required if moves()
  // Returns the pixel of a click when the button is released.
  std::optional<glm::uvec2> button(const PointerButton& button);
  void key(const Key& key, CameraControl* camera);
  void release();  // releases all held keys and buttons
  void leave() { over_ = pointing_; }
  // If on, keys move the pointer instead of the camera, starting at its position, or at the center if it is not over
  // the picture. This ends when the pointer itself moves.
  void point(bool on);
  bool points() const { return pointing_; }

  bool dragging() const { return held_.has_value(); }
  bool flying() const;
  void fly(CameraControl& camera, double seconds) const;

  // The pointer position, as a pixel and as a picture point. Empty if the pointer is not over the picture.
  std::optional<glm::uvec2> pixel() const;
  PicturePoint place() const;

 private:
  void pointBy(glm::dvec2 pixels);
  bool isInside() const { return x_ >= 0 && y_ >= 0 && x_ < width_ && y_ < height_; }
  PicturePoint inHeights(double dx, double dy) const { return {dx / height_, dy / height_}; }

  uint32_t width_ = 1, height_ = 1;
  double x_ = 0, y_ = 0;
  bool over_ = false, pointing_ = false;
  struct Held {
    Button button;
    bool shift, moved = false;
    double x, y;  // position of the press
  };
  std::optional<Held> held_;
  std::set<std::string> keys_;
};

}  // namespace latelight::view
