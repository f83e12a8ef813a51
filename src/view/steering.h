// What pointer, wheel and keys mean for a camera.
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

  // Of the picture that pointers move over, pixels.
  void resize(uint32_t width, uint32_t height);

  // Each says whether the camera moves by it.
  bool moves(const PointerMove& move) const;
  bool moves(const Key& key) const;

  void pointer(const PointerMove& move, CameraControl* camera);  // `camera`: where moves()
  // The pixel of a click, when it is over.
  std::optional<glm::uvec2> button(const PointerButton& button);
  void key(const Key& key, CameraControl* camera);
  void release();  // whatever is held
  void leave() { over_ = pointing_; }
  // Keys move the pointer instead of the camera, from where it is or else from the middle, until it moves by itself.
  void point(bool on);
  bool points() const { return pointing_; }

  bool dragging() const { return held_.has_value(); }
  bool flying() const;
  void fly(CameraControl& camera, double seconds) const;

  // Where the pointer is: the pixel, and as a place in the picture. Nothing where it is not over it.
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
    double x, y;  // where it went down
  };
  std::optional<Held> held_;
  std::set<std::string> keys_;
};

}  // namespace latelight::view
