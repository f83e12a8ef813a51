// The state of a viewing session, as reported to its user interface.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "render/submit/picking.h"
#include "view/camera_control.h"
#include "view/input.h"

namespace latelight::view {

// The choice for one side: options that differ from the defaults, by key ("layout"), and the displayed output.
struct Choice {
  std::map<std::string, std::string, std::less<>> options;
  std::string output = "picture";
  bool operator==(const Choice&) const = default;
};

// The pixel under the pointer.
struct Probe {
  uint32_t x = 0, y = 0;
  std::array<uint8_t, 4> rgba{};  // as displayed
  render::Picked surface;
};

// A positional light; directional lights are not listed.
struct LightState {
  std::string name, type;
  std::array<double, 3> position{};  // in the scene file's coordinates
  // Its position in the picture, in pixels; empty if it is behind the camera.
  std::optional<std::array<float, 2>> at;
};

struct State {
  std::string scene, device;
  std::string error;  // error message of the last input or picture; empty: no error
  uint32_t width = 0, height = 0;
  Choice choices[2];  // indexed by Side
  SetSplit split;
  std::string environment;  // as requested

  std::vector<std::string> variants;  // KHR_materials_variants
  std::string variant;                // empty: the file's default

  std::vector<std::string> cameras;     // names, which may be empty or equal
  std::string camera;                   // the value of --camera for the current camera; empty: the initial one
  std::optional<uint32_t> cameraIndex;  // that camera's index in `cameras`; empty: the initial one
  std::optional<Viewpoint> steered;     // pose of the interactive camera, which then replaces `camera`
  Navigation navigation = Navigation::Orbit;

  std::vector<std::string> animations;
  double duration = 0;         // of the selected animations, in seconds
  std::optional<double> time;  // empty: at rest
  bool playing = false;

  std::optional<std::array<uint32_t, 2>> crosshair;  // the pixel that is pointed at by keys, if any
  std::optional<render::Picked> selected;
  std::optional<Probe> probe;
  std::vector<LightState> lights;
  bool lightsMoved = false;  // if true, no command line renders this picture

  std::string command;               // shell command that renders the left choice
  std::string rightCommand;          // the same for the right choice; empty without a split
  uint32_t bytesPerPixel = 0;        // of the G-buffer with depth and light
  std::vector<std::string> targets;  // names of the layout's targets
};

// A rendered picture of a session.
struct SessionFrame {
  uint32_t width = 0, height = 0;       // in pixels; may be less than requested; 0: no picture yet
  std::vector<uint8_t> rgba;            // sRGB, straight alpha, rows from the top
  uint64_t number = 0;                  // increases whenever pixels change
  bool final = false;                   // false: a better picture follows automatically
  double milliseconds = 0;              // total render time
  std::vector<graph::PassTime> passes;  // of the left side; empty if the device has no timestamps
};

}  // namespace latelight::view
