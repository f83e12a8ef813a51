// The table of options at run time, for the command line, its help, `latelight list` and the tests.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/settings.h"

namespace latelight::render {

// The values that a number may take.
struct Range {
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  bool open = false;  // excludes `least` itself
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
  std::string normal = {};              // the default, as text; empty: none
  std::string without = {};             // what applies where it is not given and has no default, in words
  Range range = {};                     // of Integer and Number
  std::string unit = {};                // of those
  const char* topic = "";               // of `latelight list`, which describes its names
  std::vector<NamedOption> names = {};  // of Choice, and of texts with names
};

std::string_view longName(const Option& option);  // "--out"
std::string_view keyOf(const Option& option);     // in metadata and JSON: "out"

// "0 to 1 metres"; empty where any number without a unit is taken.
std::string rangeText(const Option& option);
// Throws Error(Usage) that says what the option takes, and what was given instead.
[[noreturn]] void refuse(const Option& option, std::string_view given);

// The options of a picture, in the order of options.def. read() sets one from its text, and returns that text as it
// appears in metadata, or throws Error(Usage).
std::span<const Option> options();
std::string read(Settings& settings, const Option& option, std::string_view text);

}  // namespace latelight::render
