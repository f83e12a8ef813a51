#include "app/parse.h"

#include <charconv>
#include <cmath>
#include <vector>

#include "base/text.h"
#include "shared/color.h"

namespace latelight::app {

namespace {

// Numbers by comma; empty where any part is no number.
std::vector<float> parseNumbers(std::string_view text) {
  std::vector<float> values;
  for (std::string_view part : splitAtCommas(text)) {
    const std::optional<float> value = parseNumber<float>(part);
    if (!value) return {};
    values.push_back(*value);
  }
  return values;
}

}  // namespace

std::pair<uint32_t, uint32_t> parseSize(std::string_view text, const char* option) {
  size_t x = text.find('x');
  if (x != std::string::npos) {
    auto width = parseNumber<uint32_t>(text.substr(0, x));
    auto height = parseNumber<uint32_t>(text.substr(x + 1));
    if (width && height) return {*width, *height};
  }
  badUsage("{} takes a width and a height in pixels, as in 1280x720, not \"{}\"", option, text);
}

glm::vec3 parseVector(const std::string& option, const std::string& text) {
  std::vector<float> v = parseNumbers(text);
  if (v.size() != 3) badUsage("{} takes three numbers x,y,z, not \"{}\"", option, text);
  return {v[0], v[1], v[2]};
}

glm::vec3 parseColor(const char* takes, const std::string& text) {
  glm::vec3 code(-1);
  if (text.size() == 7 && text[0] == '#') {
    for (int i = 0; i < 3; ++i) {
      unsigned value = 256;
      const char* digits = text.data() + 1 + 2 * i;
      auto [end, error] = std::from_chars(digits, digits + 2, value, 16);
      code[i] = error == std::errc() && end == digits + 2 ? static_cast<float>(value) / 255.0f : -1.0f;
    }
  } else if (std::vector<float> v = parseNumbers(text); v.size() == 3) {
    code = {v[0], v[1], v[2]};
  }
  for (int i = 0; i < 3; ++i)
    if (!(code[i] >= 0 && code[i] <= 1)) badUsage("{} #rrggbb, or r,g,b between 0 and 1, not \"{}\"", takes, text);
  return {shared::linearFromSrgb(code.x), shared::linearFromSrgb(code.y), shared::linearFromSrgb(code.z)};
}

std::pair<uint32_t, uint32_t> parseFrames(const std::string& text) {
  const std::string_view all = text;
  const size_t dash = std::min(all.find('-'), all.size());
  const auto first = parseNumber<uint32_t>(all.substr(0, dash));
  const auto last = dash == all.size() ? first : parseNumber<uint32_t>(all.substr(dash + 1));
  if (!first || !last || *last < *first || *last == ~0u)
    badUsage("--frames takes the first and the last frame's number, as in 0-47, not \"{}\"", text);
  return {*first, *last};
}

std::optional<size_t> parseIndex(std::string_view text) {
  return parseNumber<size_t>(text);
}

Orbit parseOrbit(const std::string& text) {
  std::vector<float> v = parseNumbers(text);
  if (v.size() != 2 && v.size() != 3)
    badUsage("--orbit takes azimuth,elevation[,distance] in degrees and metres, as in 30,20, not \"{}\"", text);
  const float radians = static_cast<float>(M_PI / 180.0);
  return {v[0] * radians, v[1] * radians, v.size() == 3 ? std::optional(v[2]) : std::nullopt};
}

render::SunLight parseSun(const std::string& text) {
  std::vector<float> v = parseNumbers(text);
  if (v.size() != 2 && v.size() != 3)
    badUsage("--sun takes azimuth,elevation[,lux] in degrees, as in 30,40 or 30,40,3, not \"{}\"", text);
  const float radians = static_cast<float>(M_PI / 180.0);
  render::SunLight sun{.azimuth = v[0] * radians, .elevation = v[1] * radians};
  if (v.size() == 3) sun.illuminance = v[2];
  return sun;
}

}  // namespace latelight::app
