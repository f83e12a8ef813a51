// The options of `latelight render`: as given, and parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

#include "output/aov.h"
#include "render/settings.h"
#include "scene/scene.h"

namespace latelight::app {

struct RenderOptions {
  std::string scene = "builtin:hall", out, size = "1280x720", variant;
  std::vector<std::string> allowOutside;
  std::string memory;
  std::string idNodes;
  scene::IdGrouping idGrouping;
  std::string camera, eye, target, up, orbit;
  std::optional<double> fov;
  std::vector<std::string> picks;
  std::vector<glm::uvec2> pixels;  // those
  std::string aovs, debug, hdri, background = "transparent", aa = "none", normalFrame = "world", axes = "file";
  std::string device = "auto", graph;
  std::string fogColor = "#bcbcbc";  // linear 0.5
  std::string animation, frames;
  std::optional<double> time;
  double fps = 24, turn = 0;
  bool loop = false, frameChosen = false;
  double hdriRotate = 0;
  std::string sun;
  double sunAngle = 0.53;
  uint32_t frame = 0;
  bool json = false, noSideFile = false, validate = false;
  bool normalsChosen = false, positionChosen = false;  // rather than left at their defaults
  render::Settings settings;
};

void addRenderOptions(CLI::App& command, RenderOptions& options);
// After parsing: which options were given, where that makes a difference from their defaults.
void noteChoices(const CLI::App& command, RenderOptions& options);
// Fills options.settings from the options that are words. Throws Error(Usage).
void parseSettings(RenderOptions& options);

// What --debug shows: "sheet", AOV names, or "targets". The picture then leaves as a PNG of those.
struct DebugRequest {
  std::vector<output::Aov> aovs;
  bool sheet = false;
  bool targets = false;  // the layout's own, instead of AOVs
};
// `moving`: whether there is motion to show on the sheet.
std::optional<DebugRequest> parseDebug(const std::string& debug, bool moving);

}  // namespace latelight::app
