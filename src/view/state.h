// What a viewing session has to say beside its pictures.
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

// One side's: what differs from the defaults, by key ("layout"), and what is shown of it.
struct Choice {
  std::map<std::string, std::string, std::less<>> options;
  std::string output = "picture";
  bool operator==(const Choice&) const = default;
};

// What is under the pointer.
struct Probe {
  uint32_t x = 0, y = 0;
  std::array<uint8_t, 4> rgba{};  // as shown
  render::Picked surface;
};

// That has a place: directional ones have none.
struct LightState {
  std::string name, type;
  std::array<double, 3> position{};  // the scene file's frame
  // Where it is in the picture, pixels; nothing behind the camera.
  std::optional<std::array<float, 2>> at;
};

struct State {
  std::string scene, device;
  std::string error;  // the last input's or picture's sentence; empty: all is well
  uint32_t width = 0, height = 0;
  Choice choices[2];  // by Side
  SetSplit split;
  std::string environment;  // as asked for

  std::vector<std::string> variants;  // KHR_materials_variants
  std::string variant;                // empty: the file's default

  std::vector<std::string> cameras;
  std::string camera;  // that is looked through, by name or number; empty: the one that the session begins with
  std::optional<Viewpoint> steered;  // instead, once people have moved it
  Navigation navigation = Navigation::Orbit;

  std::vector<std::string> animations;
  double duration = 0;         // of those that play, seconds
  std::optional<double> time;  // nothing: at rest
  bool playing = false;

  std::optional<std::array<uint32_t, 2>> crosshair;  // the pixel that keys point at, while they do
  std::optional<render::Picked> selected;
  std::optional<Probe> probe;
  std::vector<LightState> lights;
  bool lightsMoved = false;  // then no command line gives this picture

  std::string command;               // that renders the left choice, for a shell
  std::string rightCommand;          // the same of the right one; empty without a split
  uint32_t bytesPerPixel = 0;        // of the G-buffer, with depth and light
  std::vector<std::string> targets;  // of the layout
};

// A picture to look at.
struct Frame {
  uint32_t width = 0, height = 0;       // of the pixels here, which may be fewer than asked for; 0: there is none yet
  std::vector<uint8_t> rgba;            // sRGB, straight alpha, rows from the top
  uint64_t number = 0;                  // grows whenever pixels change
  bool final = false;                   // else a better one follows by itself
  double milliseconds = 0;              // that it took altogether
  std::vector<graph::PassTime> passes;  // of the left side; empty where the device has no clock
};

}  // namespace latelight::view
