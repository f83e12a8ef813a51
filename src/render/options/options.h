// The table of options at run time, for the command line, its help, `latelight list` and the tests.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/options/options.h"
#include "render/settings/settings.h"

namespace latelight::render {

// The values that a number accepts.
struct Range {
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  bool open = false;  // excludes `least`
  bool holds(double value) const {
    return std::isfinite(value) && (open ? value > least : value >= least) && value <= most;
  }
};
inline Range between(double least, double most) {
  return {.least = least, .most = most};
}
inline Range atLeast(double least) {
  return {.least = least};
}
inline Range above(double least) {
  return {.least = least, .open = true};
}
inline Range anything() {
  return {};
}

enum class OptionKind { Flag, Integer, Number, Choice, Text, List };
enum class OptionEffect { Runtime, Compiled };  // Compiled: changing it creates new pipelines

struct Option {
  std::string group;   // the heading that it is listed under
  const char* name;    // "--exposure"; "-o,--out" with its letter; "SCENE" for the argument
  const char* member;  // of latelight::Options, or of the command line's own options
  OptionKind kind = OptionKind::Text;
  OptionEffect effect = OptionEffect::Runtime;
  const char* help = "";
  std::string defaultValue = {};        // the default, as text; empty: none
  std::string without = {};             // in words: what applies without a value and a default
  Range range = {};                     // for Integer and Number
  std::string unit = {};                // for the same
  const char* topic = "";               // of `latelight list` that describes the names
  std::vector<NamedOption> names = {};  // for Choice, and for texts with names
};

std::string_view longName(const Option& option);  // "--out"
std::string_view keyOf(const Option& option);     // in metadata and JSON: "out"

// Returns text such as "0 to 1 meters"; empty if any number without a unit is accepted.
std::string rangeText(const Option& option);
// Throws Error(Usage) that states which values the option accepts, and the value that was given.
[[noreturn]] void refuse(const Option& option, std::string_view given);

// The options of a picture, in the order of options.def. read() sets one from its text and returns the text as it
// appears in metadata, or throws Error(Usage).
std::span<const Option> options();
// Returns the values that the option named "--shutter" accepts, for parts of jobs and scenes with the same meaning.
const Range& rangeOf(std::string_view name);
std::string read(Settings& settings, const Option& option, std::string_view text);

// Throws Error(Usage) if a value is out of range, or if two contradict each other.
void checkSettings(const Settings& settings);
// Throws Error(Usage) if an option was given, by key, whose value the layout fixes.
void checkLayoutOptions(const Settings& settings, const std::map<std::string, std::string, std::less<>>& given);
// Returns true if the settings choose or repeat an animation but have no time, so that the scene would be at rest.
// checkSettings() accepts them, because a sequence and the viewer set the time later.
bool playsWithoutTime(const Settings& settings);

}  // namespace latelight::render
