// Parses option values from text. Each function throws Error(Usage) with a sentence that shows the right form.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace latelight::app {

glm::dvec3 parseVector(const std::string& option, const std::string& text);  // "x,y,z"
std::pair<uint32_t, uint32_t> parseFrames(const std::string& text);          // "0-47", or "5"
// Parses "1,100,10k,1M". Rejects 0.
std::vector<uint64_t> parseCounts(const std::string& option, const std::string& text);
// Throws unless --budget is a number of seconds above 0.
void checkBudget(double seconds);
// Throws unless the name of a page, which `writer` writes, ends in .html or .htm, or is - for standard output.
void checkPageName(std::string_view writer, const std::string& name);
int64_t parseStep(const std::string& text);               // "next", "previous", or frames other than 0
std::optional<size_t> parseIndex(std::string_view text);  // an integer, or nothing

struct Orbit {
  float azimuth, elevation;       // radians
  std::optional<float> distance;  // meters
};
Orbit parseOrbit(const std::string& text);  // "az,el[,dist]" in degrees

}  // namespace latelight::app
