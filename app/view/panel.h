// The panel next to the image: the shown output, its options, and times.
#pragma once

#include <imgui/imgui.h>

#include <deque>
#include <functional>
#include <map>
#include <string>

#include "view/input.h"
#include "view/state.h"

namespace latelight::app {

using Send = std::function<void(view::Input)>;

// Milliseconds of the last finished images, and of each of their passes.
struct TimeHistory {
  std::deque<float> pictures;
  std::map<std::string, std::deque<float>> passes;
  double last = 0;
  void add(const view::SessionFrame& frame);
};

// The state of the panel, and its requests to the window.
struct PanelMemory {
  view::Side side = view::Side::Left;  // the side whose options are shown
  bool shown = true, help = false, handles = false;
  std::string scene, environment, file = "screenshot.png";
  TimeHistory times;
  bool copies = false;   // copy the command to the clipboard
  bool focuses = false;  // move the keyboard focus to the panel
};

// Returns the command of the side whose options are shown.
const std::string& commandOf(const view::State& state, const PanelMemory& memory);

void drawPanel(const view::State& state, const view::SessionFrame& frame, PanelMemory& memory, const Send& send,
               ImVec2 from, ImVec2 size);
void drawHelp(PanelMemory& memory);

}  // namespace latelight::app
