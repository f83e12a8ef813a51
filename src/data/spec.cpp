#include "data/spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "data/json_text.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

std::string described(Limits limits) {
  const Limits all;
  if (limits.least == all.least && limits.most == all.most) return "a number";
  if (limits.least == kPositive.least && limits.most == all.most) return "a number above 0";
  if (limits.most == all.most) return fmt::format("a number of at least {}", limits.least);
  if (limits.least == kPositive.least) return fmt::format("a number above 0 and up to {}", limits.most);
  return fmt::format("a number from {} to {}", limits.least, limits.most);
}

double numberOf(const Json& value, const std::string& path, Limits limits) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (std::abs(number) > kLargest) badUsage("{} must not exceed {:g}, but is {}", path, kLargest, shown(value));
  if (!(number >= limits.least && number <= limits.most))
    badUsage("{} must be {}, not {}", path, described(limits), shown(value));
  return number;
}

std::vector<double> numbersOf(const Json& value, const std::string& path, size_t least, size_t most, Limits limits) {
  if (!value.is_array() || value.size() < least || value.size() > most) {
    const std::string many = least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most);
    badUsage("{} must be a list of {} numbers, not {}", path, many, shown(value));
  }
  std::vector<double> numbers;
  for (size_t i = 0; i < value.size(); ++i)
    numbers.push_back(numberOf(value[i], fmt::format("{}[{}]", path, i), limits));
  return numbers;
}

std::string textOf(const Json& value, const std::string& path) {
  if (!value.is_string()) badUsage("{} must be a string, not {}", path, shown(value));
  return value.get<std::string>();
}

}  // namespace

std::string shown(const Json& value) {
  return shortened(dumped(value));
}

Spec::Spec(const Json& value, std::string path) : value_(&value), path_(std::move(path)) {
  if (!value.is_object()) badUsage("{} must be an object, not {}", path_, shown(value));
}

std::string Spec::pathOf(std::string_view key) const {
  return fmt::format("{}.{}", path_, key);
}

bool Spec::has(std::string_view key) {
  known_.emplace(key);
  return value_->contains(key);
}

const Json& Spec::at(std::string_view key) {
  known_.emplace(key);
  const auto found = value_->find(key);
  if (found == value_->end()) badUsage("{} needs \"{}\"", path_, key);
  return *found;
}

std::string Spec::text(std::string_view key, std::optional<std::string> normal) {
  return normal && !has(key) ? *normal : textOf(at(key), pathOf(key));
}

std::string Spec::choice(std::string_view key, std::initializer_list<std::string_view> choices,
                         std::optional<std::string> normal) {
  if (normal && !has(key)) return *normal;
  const Json& value = at(key);
  if (!value.is_string() || std::ranges::find(choices, value.get<std::string>()) == choices.end())
    badUsage("{} must be one of {}, not {}", pathOf(key), fmt::join(choices, ", "), shown(value));
  return value.get<std::string>();
}

bool Spec::flag(std::string_view key, bool normal) {
  if (!has(key)) return normal;
  const Json& value = at(key);
  if (!value.is_boolean()) badUsage("{} must be true or false, not {}", pathOf(key), shown(value));
  return value.get<bool>();
}

double Spec::number(std::string_view key, Limits limits, std::optional<double> normal) {
  return normal && !has(key) ? *normal : numberOf(at(key), pathOf(key), limits);
}

uint64_t Spec::count(std::string_view key, uint64_t least, uint64_t most, std::optional<uint64_t> normal) {
  if (normal && !has(key)) return *normal;
  const Json& value = at(key);
  const bool whole = value.is_number_unsigned() || (value.is_number_integer() && value.get<int64_t>() >= 0);
  if (!whole || value.get<uint64_t>() < least || value.get<uint64_t>() > most)
    badUsage("{} must be a whole number from {} to {}, not {}", pathOf(key), least, most, shown(value));
  return value.get<uint64_t>();
}

glm::dvec3 Spec::vector(std::string_view key, Limits limits) {
  const std::vector<double> v = numbers(key, 3, 3, limits);
  return {v[0], v[1], v[2]};
}

Interval Spec::interval(std::string_view key, Limits limits, std::optional<Interval> normal) {
  if (normal && !has(key)) return *normal;
  const Json& value = at(key);
  if (value.is_number()) {
    const double both = numberOf(value, pathOf(key), limits);
    return {both, both};
  }
  if (!value.is_array() || value.size() != 2)
    badUsage("{} must be {}, or a list of the minimum and maximum, not {}", pathOf(key), described(limits),
             shown(value));
  const std::vector<double> ends = numbersOf(value, pathOf(key), 2, 2, limits);
  if (ends[0] > ends[1]) badUsage("{} must list the minimum first, not {}", pathOf(key), shown(value));
  return {ends[0], ends[1]};
}

Spec::Counts Spec::counts(std::string_view key, uint64_t most) {
  const Interval range = interval(key, {0, double(most)});
  if (range.low != std::floor(range.low) || range.high != std::floor(range.high))
    badUsage("{} must be whole numbers, not {}", pathOf(key), shown(at(key)));
  return {static_cast<uint64_t>(range.low), static_cast<uint64_t>(range.high)};
}

Spec::Corners Spec::corners(std::string_view key, Limits limits) {
  const Json& value = at(key);
  if (!value.is_array() || value.size() != 2) {
    const glm::dvec3 both = vector(key, limits);
    return {both, both};
  }
  glm::dvec3 ends[2];
  for (size_t end = 0; end < 2; ++end) {
    const std::vector<double> v = numbersOf(value[end], fmt::format("{}[{}]", pathOf(key), end), 3, 3, limits);
    ends[end] = {v[0], v[1], v[2]};
  }
  for (int axis = 0; axis < 3; ++axis)
    if (ends[0][axis] > ends[1][axis])
      badUsage("{} must list the minimum values first, not {}", pathOf(key), shown(value));
  return {ends[0], ends[1]};
}

std::vector<double> Spec::numbers(std::string_view key, size_t least, size_t most, Limits limits) {
  return numbersOf(at(key), pathOf(key), least, most, limits);
}

std::vector<double> Spec::matrix(std::string_view key, size_t rows, size_t columns) {
  const Json& value = at(key);
  if (!value.is_array() || value.size() != rows)
    badUsage("{} must be a list of {} rows of {} numbers, not {}", pathOf(key), rows, columns, shown(value));
  std::vector<double> all;
  for (size_t row = 0; row < rows; ++row)
    for (const double number : numbersOf(value[row], fmt::format("{}[{}]", pathOf(key), row), columns, columns, {}))
      all.push_back(number);
  return all;
}

std::vector<std::string> Spec::texts(std::string_view key) {
  const Json& value = at(key);
  if (value.is_string()) return {value.get<std::string>()};
  if (!value.is_array() || value.empty())
    badUsage("{} must be a string or a list of strings, not {}", pathOf(key), shown(value));
  std::vector<std::string> all;
  for (size_t i = 0; i < value.size(); ++i) all.push_back(textOf(value[i], fmt::format("{}[{}]", pathOf(key), i)));
  return all;
}

Spec Spec::object(std::string_view key) {
  return Spec(at(key), pathOf(key));
}

std::vector<Spec> Spec::objects(std::string_view key) {
  const Json& value = at(key);
  if (!value.is_array() || value.empty()) badUsage("{} must be a list of objects, not {}", pathOf(key), shown(value));
  constexpr uint64_t kKnownKeys = 8 * 80;
  const auto memory = std::make_shared<MemoryClaim>(
      value.size() * (sizeof(Spec) + kKnownKeys + path_.size() + key.size()), pathOf(key));
  std::vector<Spec> all;
  all.reserve(value.size());
  for (size_t i = 0; i < value.size(); ++i) {
    all.emplace_back(value[i], fmt::format("{}[{}]", pathOf(key), i));
    all.back().memory_ = memory;
  }
  return all;
}

void Spec::finish() const {
  for (const auto& [key, value] : value_->items())
    if (!known_.contains(key)) {
      std::vector<std::string> known(known_.begin(), known_.end());
      badUsage("{} has the unknown key \"{}\": the keys are {}", path_, key, fmt::join(known, ", "));
    }
}

}  // namespace latelight::data
