// Values of options from their text. Each throws Error(Usage) with a sentence that shows the right form.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>

#include "base/error.h"
#include "render/settings.h"

namespace latelight::app {

std::pair<uint32_t, uint32_t> parseSize(std::string_view text, const char* option = "--size");  // "1280x720"
glm::vec3 parseVector(const std::string& option, const std::string& text);                      // "x,y,z"
// "#rrggbb" or "r,g,b" sRGB -> linear; `takes` begins the sentence where it is neither
glm::vec3 parseColor(const char* takes, const std::string& text);
std::pair<uint32_t, uint32_t> parseFrames(const std::string& text);  // "0-47", or "5"
std::optional<size_t> parseIndex(std::string_view text);             // a whole number, or nothing

struct Orbit {
  float azimuth, elevation;       // radians
  std::optional<float> distance;  // metres
};
Orbit parseOrbit(const std::string& text);           // "az,el[,dist]" in degrees and metres
render::SunLight parseSun(const std::string& text);  // "az,el[,lux]" in degrees

template <typename T>
T parseChoice(const char* option, const std::string& text, std::initializer_list<std::pair<const char*, T>> choices) {
  std::string names;
  for (const auto& [name, value] : choices) {
    if (text == name) return value;
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  badUsage("{} takes one of {}, not \"{}\"", option, names, text);
}

}  // namespace latelight::app
