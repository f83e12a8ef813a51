#include "app/parse.h"

#include <cmath>
#include <cstdlib>

#include "base/lowercase.h"
#include "base/text.h"
#include "scene/builtin/builtin.h"

namespace latelight::app {

glm::dvec3 parseVector(const std::string& option, const std::string& text) {
  const std::vector<double> v = parseNumbers<double>(text);
  if (v.size() != 3) badUsage("{} takes three numbers x,y,z, not \"{}\"", option, text);
  return {v[0], v[1], v[2]};
}

std::pair<uint32_t, uint32_t> parseFrames(const std::string& text) {
  const std::string_view all = text;
  const size_t dash = std::min(all.find('-'), all.size());
  const auto first = parseNumber<uint32_t>(all.substr(0, dash));
  const auto last = dash == all.size() ? first : parseNumber<uint32_t>(all.substr(dash + 1));
  if (!first || !last || *last < *first || *last == ~0u)
    badUsage("--frames requires the numbers of the first and last frame, such as 0-47, not \"{}\"", text);
  return {*first, *last};
}

std::vector<uint64_t> parseCounts(const std::string& option, const std::string& text) {
  std::vector<uint64_t> counts;
  for (std::string_view part : splitAtCommas(text)) {
    const std::optional<uint64_t> count = scene::parseCount(part);
    if (!count || *count == 0)
      badUsage(
          "{} requires comma-separated whole numbers, with k for thousands and M for millions, such as 50k,1M, not "
          "\"{}\"",
          option, text);
    counts.push_back(*count);
  }
  return counts;
}

void checkBudget(double seconds) {
  if (!(seconds > 0)) badUsage("--budget must be above 0 seconds, not {}", seconds);
}

void checkPageName(std::string_view writer, const std::string& name) {
  const std::string ending = lowercaseExtension(name);
  if (name != "-" && ending != ".html" && ending != ".htm")
    badUsage("{} writes an HTML page; give it a name that ends in .html, not \"{}\"", writer, name);
}

int64_t parseStep(const std::string& text) {
  constexpr int64_t kMaxStep = 1'000'000;
  if (text == "next") return 1;
  if (text == "previous") return -1;
  const auto step = parseNumber<int64_t>(std::string_view(text).substr(text.starts_with('+') ? 1 : 0));
  if (!step || *step == 0 || std::abs(*step) > kMaxStep)
    badUsage("--to takes next, previous or a number of frames other than 0, up to {}, not \"{}\"", kMaxStep, text);
  return *step;
}

std::optional<size_t> parseIndex(std::string_view text) {
  return parseNumber<size_t>(text);
}

Orbit parseOrbit(const std::string& text) {
  std::vector<float> v = parseNumbers(text);
  if (v.size() != 2 && v.size() != 3)
    badUsage("--orbit requires azimuth,elevation[,distance] in degrees and meters, such as 30,20, not \"{}\"", text);
  const float radians = static_cast<float>(M_PI / 180.0);
  return {v[0] * radians, v[1] * radians, v.size() == 3 ? std::optional(v[2]) : std::nullopt};
}

}  // namespace latelight::app
