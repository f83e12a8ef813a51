#include "view/steering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace latelight::view {

namespace {

constexpr double kClick = 3;           // maximum movement of a click, in pixels
constexpr double kKeyDrag = 1 / 36.0;  // an arrow key is a drag by this distance: 5 degrees
constexpr double kKeyLeap = 10;        // pointer movement of Shift and an arrow key, in pixels

struct Flight {
  std::string_view key;
  glm::dvec3 direction;  // right, forward, up
};
constexpr std::array<Flight, 6> kFlights{
    {{"w", {0, 1, 0}}, {"s", {0, -1, 0}}, {"a", {-1, 0, 0}}, {"d", {1, 0, 0}}, {"q", {0, 0, -1}}, {"e", {0, 0, 1}}}};

struct Turn {
  std::string_view key;
  double azimuth, elevation;  // in half turns
};
constexpr std::array<Turn, 3> kTurns{{{"1", 0, 0}, {"3", 0.5, 0}, {"7", 0, 0.5}}};  // front, right, top

std::optional<glm::dvec2> arrow(const std::string& key) {
  if (key == "ArrowLeft") return glm::dvec2(1, 0);
  if (key == "ArrowRight") return glm::dvec2(-1, 0);
  if (key == "ArrowUp") return glm::dvec2(0, 1);
  if (key == "ArrowDown") return glm::dvec2(0, -1);
  return std::nullopt;
}

double dollySteps(const std::string& key) {
  return key == "+" || key == "=" || key == "PageUp" ? 1 : key == "-" || key == "PageDown" ? -1 : 0;
}

bool isFlight(const std::string& key) {
  for (const Flight& flight : kFlights)
    if (key == flight.key) return true;
  return false;
}

}  // namespace

void Steering::resize(uint32_t width, uint32_t height) {
  width_ = width, height_ = height;
  if (pointing_) pointBy({0, 0});
  over_ = over_ && isInside();
}

bool Steering::moves(const PointerMove& move) const {
  return held_ && (held_->moved || std::hypot(move.x - held_->x, move.y - held_->y) > kClick);
}

void Steering::pointer(const PointerMove& move, CameraControl* camera) {
  const double fromX = held_ && !held_->moved ? held_->x : x_, fromY = held_ && !held_->moved ? held_->y : y_;
  if (camera && held_) {
    const PicturePoint drag = inHeights(move.x - fromX, move.y - fromY);
    held_->moved = true;
    if (held_->button != Button::Left || held_->shift)
      camera->pan(drag);
    else if (navigation == Navigation::Fly)
      camera->look(drag);
    else
      camera->orbit(drag);
  }
  x_ = move.x, y_ = move.y;
  pointing_ = false;
  over_ = isInside();
}

std::optional<glm::uvec2> Steering::button(const PointerButton& button) {
  if (button.down) {
    if (!held_) held_ = Held{button.button, button.shift, false, x_, y_};
    return std::nullopt;
  }
  if (!held_ || held_->button != button.button) return std::nullopt;
  const bool click = !held_->moved && button.button == Button::Left;
  held_.reset();
  return click ? pixel() : std::nullopt;
}

bool Steering::moves(const Key& key) const {
  if (!key.down) return false;
  for (const Turn& turn : kTurns)
    if (key.name == turn.key) return true;
  if (arrow(key.name)) return !pointing_;
  return dollySteps(key.name) != 0 || (navigation == Navigation::Fly && isFlight(key.name));
}

void Steering::key(const Key& key, CameraControl* camera) {
  if (!key.down)
    keys_.erase(key.name);
  else if (isFlight(key.name))
    keys_.insert(key.name);
  if (!key.down) return;
  const auto way = arrow(key.name);
  if (way && pointing_) pointBy(-*way * (key.shift ? kKeyLeap : 1));
  if (!camera) return;
  if (way) {
    const PicturePoint drag = *way * kKeyDrag;
    if (key.shift)
      camera->pan(drag);
    else if (navigation == Navigation::Fly)
      camera->look(-drag);
    else
      camera->orbit(drag);
  }
  if (const double steps = dollySteps(key.name); steps != 0) camera->dolly(steps, camera->view().target);
  for (const Turn& turn : kTurns)
    if (key.name == turn.key) camera->turnTo(turn.azimuth * M_PI, turn.elevation * M_PI);
}

void Steering::point(bool on) {
  if (on && !over_) x_ = width_ / 2, y_ = height_ / 2;
  over_ = pointing_ = on;
}

void Steering::pointBy(glm::dvec2 pixels) {
  x_ = std::clamp(x_ + pixels.x, 0.0, width_ - 1.0);
  y_ = std::clamp(y_ + pixels.y, 0.0, height_ - 1.0);
}

void Steering::release() {
  held_.reset();
  keys_.clear();
}

bool Steering::flying() const {
  return navigation == Navigation::Fly && !keys_.empty();
}

void Steering::fly(CameraControl& camera, double seconds) const {
  for (const Flight& flight : kFlights)
    if (keys_.contains(std::string(flight.key))) camera.fly(flight.direction, seconds);
}

std::optional<glm::uvec2> Steering::pixel() const {
  if (!over_) return std::nullopt;
  return glm::uvec2(static_cast<uint32_t>(x_), static_cast<uint32_t>(y_));
}

PicturePoint Steering::place() const {
  return inHeights(x_ - width_ / 2.0, y_ - height_ / 2.0);
}

}  // namespace latelight::view
