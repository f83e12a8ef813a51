// What people do with a viewing session, from whatever window, page or test: plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace latelight::view {

// Of a split picture. Without a split there is the left one alone.
enum class Side : uint8_t { Left, Right };

enum class Button : uint8_t { Left, Middle, Right };
enum class Navigation : uint8_t { Orbit, Fly };

// Pixels of the picture that the session was told to make, from the upper left; y down.
struct Resize {
  uint32_t width, height;
};
struct PointerMove {
  double x, y;
};
struct PointerLeave {};
// Where the pointer moved last. A click, which moves nothing, picks what is there.
struct PointerButton {
  Button button;
  bool down;
  bool shift = false;
};
struct Wheel {
  double steps;  // up is positive, and goes nearer
};
// `name` as KeyboardEvent.key has it: "w", "ArrowLeft", "Home", "Escape".
struct Key {
  std::string name;
  bool down;
  bool shift = false;
};
struct Blur {};  // no key and no button is held any more

// An option of options.def by its name, "--layout" or "layout", as text; an empty text is its default. Flags take
// "true".
// --size is Resize's.
struct SetOption {
  std::string name, value;
  Side side = Side::Left;
};
// "picture", or what --debug takes: names of outputs, "lights", "sheet", "targets", "target:NAME".
struct ShowOutput {
  std::string name;
  Side side = Side::Left;
};
// The right choice begins as a copy of the left one.
struct SetSplit {
  enum Mode : uint8_t { Off, Slider, Difference } mode = Off;
  double at = 0.5;           // of the picture's width, where the right side begins
  double amplification = 8;  // of differences
};
struct UseCamera {
  std::string name;  // of the scene, or its number; empty: the one that it begins with
};
struct UseEnvironment {
  std::string name;  // as --hdri takes it; empty: as the scene says
};
// A picture that is in no file here, with the name that it has where it comes from.
struct GiveEnvironment {
  std::string name;
  std::shared_ptr<const std::vector<std::byte>> file;
};
struct SetNavigation {
  Navigation mode;
};
struct Play {
  bool on;
};
// Lights by their place in State::lights. Moved in the scene file's frame; or, at their own depth, dragged to a pixel
// or by some pixels from where they are.
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
struct Screenshot {  // of a side, as a PNG file: what the side's command line writes
  std::string path;
  Side side = Side::Left;
};
struct Reload {};
struct OpenScene {  // instead of the one that is shown: its cameras, at rest; all other options stay
  std::string source;
};
struct UseVariant {
  std::string name;  // of KHR_materials_variants; empty: the file's default
};

using Input = std::variant<Resize, PointerMove, PointerLeave, PointerButton, Wheel, Key, Blur, SetOption, ShowOutput,
                           SetSplit, UseCamera, UseEnvironment, GiveEnvironment, SetNavigation, Play, MoveLight,
                           DragLight, NudgeLight, Screenshot, Reload, OpenScene, UseVariant>;

}  // namespace latelight::view
