// Input events and commands for a viewing session, as plain values. They come from a window, a page or a test.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace latelight::view {

// The side of a split picture. Without a split, only Left exists.
enum class Side : uint8_t { Left, Right };

enum class Button : uint8_t { Left, Middle, Right };
enum class Navigation : uint8_t { Orbit, Fly };

// The size of the requested picture in pixels. Pointer coordinates are in these pixels, from the upper left corner, y
// down.
struct Resize {
  uint32_t width, height;
};
struct PointerMove {
  double x, y;
};
struct PointerLeave {};
// At the last pointer position. A click, that is, a press and release without movement, picks the surface there.
struct PointerButton {
  Button button;
  bool down;
  bool shift = false;
};
struct Wheel {
  double steps;  // up is positive and moves closer
};
// `name` is that of KeyboardEvent.key: "w", "ArrowLeft", "Home", "Escape".
struct Key {
  std::string name;
  bool down;
  bool shift = false;
};
struct Blur {};  // releases all keys and buttons

// Sets an option of options.def by its name, "--layout" or "layout". An empty value is the default. The value of flags
// is "true". Resize replaces --size.
struct SetOption {
  std::string name, value;
  Side side = Side::Left;
};
// "picture", or a value of --debug: names of outputs, "lights", "sheet", "targets", "target:NAME".
struct ShowOutput {
  std::string name;
  Side side = Side::Left;
};
// The right choice starts as a copy of the left one.
struct SetSplit {
  enum Mode : uint8_t { Off, Slider, Difference } mode = Off;
  double at = 0.5;           // start of the right side, as a fraction of the width
  double amplification = 8;  // of differences
};
// Selects a camera of the scene: a name, an index, or "#" and an index, which is unambiguous (scene/camera_selector.h).
struct UseCamera {
  std::string name;  // empty: the initial camera
};
struct UseEnvironment {
  std::string name;  // a value of --hdri; empty: the scene's
};
// An environment image that is not a file of this machine, with its original name. If that is the value of --hdri, the
// environment is named "sent-" and that name, so that both can be selected.
struct UploadEnvironment {
  std::string name;
  std::shared_ptr<const std::vector<std::byte>> file;
};
struct SetNavigation {
  Navigation mode;
};
struct Play {
  bool on;
};
// Commands that move a light; `light` is its index in State::lights. MoveLight sets its position in the scene file's
// coordinates. DragLight moves it to a pixel and NudgeLight by a number of pixels, both at constant depth.
struct MoveLight {
  uint32_t light;
  std::array<double, 3> position;
};
struct DragLight {
  uint32_t light;
  double x, y;
};
struct NudgeLight {
  uint32_t light;
  double dx, dy;
};
struct Screenshot {  // writes a PNG file, with the result of the side's command line
  std::string path;
  Side side = Side::Left;
};
struct Reload {};
struct OpenScene {  // replaces the scene: resets cameras and time; all other options are kept
  std::string source;
};
struct UseVariant {
  std::string name;  // name in KHR_materials_variants; empty: the file's default
};

using Input = std::variant<Resize, PointerMove, PointerLeave, PointerButton, Wheel, Key, Blur, SetOption, ShowOutput,
                           SetSplit, UseCamera, UseEnvironment, UploadEnvironment, SetNavigation, Play, MoveLight,
                           DragLight, NudgeLight, Screenshot, Reload, OpenScene, UseVariant>;

}  // namespace latelight::view
