// The panel beside the picture: what is shown, with which choices, and what it costs.
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

// Milliseconds of the last whole pictures, and of each of their passes.
struct TimeHistory {
  std::deque<float> pictures;
  std::map<std::string, std::deque<float>> passes;
  double last = 0;
  void add(const view::Frame& frame);
};

// What the panel remembers, and what it asks of its window.
struct PanelMemory {
  view::Side side = view::Side::Left;  // whose options are shown
  bool shown = true, help = false, handles = false;
  std::string scene, environment, file = "screenshot.png";
  TimeHistory times;
  bool copies = false;   // the command, to the clipboard
  bool focuses = false;  // keys go to the panel from here on
};

// Of the side whose options are shown.
const std::string& commandOf(const view::State& state, const PanelMemory& memory);

void drawPanel(const view::State& state, const view::Frame& frame, PanelMemory& memory, const Send& send, ImVec2 from,
               ImVec2 size);
void drawHelp(PanelMemory& memory);

}  // namespace latelight::app
