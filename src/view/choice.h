// The choice for one side of a split view: options by name, and an output.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "output/debug_request.h"
#include "render/settings/settings.h"
#include "view/state.h"

namespace latelight::view {

// The settings of a choice at a given size, and the debug output that it displays; empty for the picture.
struct ChosenSettings {
  render::Settings settings;
  std::optional<output::DebugRequest> debug;
};
// Throws Error(Usage) if the options are invalid.
ChosenSettings settingsOf(const Choice& choice, uint32_t width, uint32_t height);

// Returns the choice with one option changed; an empty value restores the default. Throws Error(Usage), also if options
// then contradict each other.
Choice withOption(const Choice& choice, std::string_view name, std::string_view value);
Choice withOutput(const Choice& choice, std::string_view output);

// Returns the options as words of a command line, without those that have no effect next to the others, because the
// command line rejects them.
std::vector<std::string> wordsOf(const Choice& choice);

}  // namespace latelight::view
