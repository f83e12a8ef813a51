// One side of what is shown: options by name, and one of the outputs.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "output/debug_request.h"
#include "render/settings/settings.h"
#include "view/state.h"

namespace latelight::view {

// Its settings at a size, and what they make a picture of, if that is not the picture.
struct ChosenSettings {
  render::Settings settings;
  std::optional<output::DebugRequest> debug;
};
// Throws Error(Usage) where they can't be.
ChosenSettings settingsOf(const Choice& choice, uint32_t width, uint32_t height);

// The choice with one option changed; an empty value is its default. Throws Error(Usage), also where options then
// contradict each other.
Choice withOption(const Choice& choice, std::string_view name, std::string_view value);
Choice withOutput(const Choice& choice, std::string_view output);

// The options as a command line takes them: without those that mean nothing beside the others, and are refused there.
std::vector<std::string> wordsOf(const Choice& choice);

}  // namespace latelight::view
