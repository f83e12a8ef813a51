// Builds a table of options from a list such as options.def: how the members of a struct are described, set from text
// and checked.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/text.h"
#include "render/options/options.h"

namespace latelight::render {

// Returns the number, or throws Error(Usage).
template <typename T>
T readNumber(const Option& option, std::string_view text) {
  using Parsed = std::conditional_t<std::floating_point<T>, double, T>;
  const std::string_view digits = text.starts_with('+') ? text.substr(1) : text;
  const std::optional<Parsed> value = parseNumber<Parsed>(digits);
  if (!value || !option.range.holds(*value) || !std::isfinite(static_cast<T>(*value))) refuse(option, text);
  return static_cast<T>(*value);
}

template <typename T>
void checkNumber(const Option& option, T value) {
  if (!option.range.holds(value)) refuse(option, fmt::format("{}", value));
}

// Specialized for types of text options: the names that the text accepts, and the constraints on its value.
template <typename T>
std::vector<NamedOption> namesOfText() {
  return {};
}
template <typename T>
void checkText(const Option&, const T&) {}

template <typename Target>
class OptionTable {
 public:
  void group(const char* title) { group_ = title; }

  void flag(bool Target::*member, Option option) {
    option.kind = OptionKind::Flag;
    add(option, [member](Target& t, const Option&, std::string_view text) {
      t.*member = true;
      return std::string("true");
    });
  }

  template <typename T>
  void number(T Target::*member, Option option, T defaultValue, Range range, const char* unit) {
    describeNumber<T>(option, range, unit);
    option.defaultValue = fmt::format("{}", defaultValue);
    add(
        option,
        [member](Target& t, const Option& o, std::string_view text) {
          return fmt::format("{}", t.*member = readNumber<T>(o, text));
        },
        [member](const Target& t, const Option& o) { checkNumber(o, t.*member); });
  }

  template <typename T>
  void optional(std::optional<T> Target::*member, Option option, Range range, const char* unit, const char* without) {
    describeNumber<T>(option, range, unit);
    option.without = without;
    add(
        option,
        [member](Target& t, const Option& o, std::string_view text) {
          t.*member = readNumber<T>(o, text);
          return fmt::format("{}", *(t.*member));
        },
        [member](const Target& t, const Option& o) {
          if (t.*member) checkNumber(o, *(t.*member));
        });
  }

  // The text is in degrees, the member in radians.
  void angle(float Target::*member, Option option, double defaultValue, Range range) {
    describeNumber<float>(option, range, "degrees");
    option.defaultValue = fmt::format("{}", defaultValue);
    add(
        option,
        [member](Target& t, const Option& o, std::string_view text) {
          const double degrees = readNumber<double>(o, text);
          t.*member = radians(degrees);
          return fmt::format("{}", degrees);
        },
        [member](const Target& t, const Option& o) {
          Range rounded = o.range;
          rounded.least = radians(rounded.least), rounded.most = radians(rounded.most);
          if (!rounded.holds(t.*member)) refuse(o, fmt::format("{}", t.*member / radians(1)));
        });
  }

  template <typename Enum>
  void choice(Enum Target::*member, Option option, const char* defaultValue, const char* topic) {
    describeNames(option, defaultValue, topic, choices<Enum>());
    add(option, [member](Target& t, const Option& o, std::string_view text) {
      t.*member = readChoice<Enum>(o.name, text);
      return std::string(text);
    });
  }

  // An entry of a registry, whose entries have a name and a description.
  template <typename Entry>
  void entry(const Entry* Target::*member, Option option, const char* defaultValue, const char* topic,
             std::span<const NamedOption> names) {
    describeNames(option, defaultValue, topic, names);
    add(option, [member](Target& t, const Option& o, std::string_view text) {
      t.*member = &readEntry<Entry>(o.name, text);
      return std::string(text);
    });
  }

  template <typename T>
  void text(T Target::*member, Option option, const char* defaultValue, const char* topic) {
    option.defaultValue = defaultValue;
    option.topic = topic;
    option.names = namesOfText<T>();
    add(
        option,
        [member](Target& t, const Option& o, std::string_view text) {
          t.*member = readText<T>(o.name, text);
          return std::string(text);
        },
        [member](const Target& t, const Option& o) { checkText(o, t.*member); });
  }

  // An option with its own syntax.
  void add(Option option, std::function<std::string(Target&, const Option&, std::string_view)> read,
           std::function<void(const Target&, const Option&)> check = {}) {
    option.group = group_;
    options_.push_back(std::move(option));
    readers_.push_back(std::move(read));
    checks_.push_back(std::move(check));
  }

  std::span<const Option> options() const { return options_; }
  // Sets the member from the text, and returns the text as it appears in metadata.
  std::string read(Target& target, const Option& option, std::string_view text) const {
    return readers_[static_cast<size_t>(&option - options_.data())](target, option, text);
  }
  void check(const Target& target) const {
    for (size_t i = 0; i < options_.size(); ++i)
      if (checks_[i]) checks_[i](target, options_[i]);
  }

 private:
  template <typename T>
  static void describeNumber(Option& option, Range range, const char* unit) {
    option.kind = std::floating_point<T> ? OptionKind::Number : OptionKind::Integer;
    option.range = range;
    option.unit = unit;
  }
  static void describeNames(Option& option, const char* defaultValue, const char* topic,
                            std::span<const NamedOption> names) {
    option.kind = OptionKind::Choice;
    option.defaultValue = defaultValue;
    option.topic = topic;
    option.names.assign(names.begin(), names.end());
  }

  std::string group_;
  std::vector<Option> options_;
  std::vector<std::function<std::string(Target&, const Option&, std::string_view)>> readers_;
  std::vector<std::function<void(const Target&, const Option&)>> checks_;  // empty: nothing to check
};

}  // namespace latelight::render
