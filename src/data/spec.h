// A part of a job as the user wrote it: a JSON object with strict validation. All functions report invalid values by
// Error(Usage) that names the key's path, such as "cameras[2].radius".
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"

namespace latelight::data {

// The maximum magnitude of numbers, so that their squares stay within the range of float.
inline constexpr double kLargest = 1e15;

// The accepted range of a number; both ends are included.
struct Limits {
  double least = -kLargest, most = kLargest;
};
inline constexpr Limits kPositive{std::numeric_limits<double>::min()}, kNotNegative{0};

// An interval from which values are drawn. Both ends of a single value are equal.
struct Interval {
  double low = 0, high = 0;
};

class Spec {
 public:
  // `value` must outlive the Spec.
  Spec(const nlohmann::ordered_json& value, std::string path);

  const std::string& path() const { return path_; }
  std::string pathOf(std::string_view key) const;
  bool has(std::string_view key);
  // Returns the value itself; throws if it is missing.
  const nlohmann::ordered_json& at(std::string_view key);

  // The functions below read a value by type. A key without a default, `normal`, is required.
  std::string text(std::string_view key, std::optional<std::string> normal = {});
  std::string choice(std::string_view key, std::initializer_list<std::string_view> choices,
                     std::optional<std::string> normal = {});
  bool flag(std::string_view key, bool normal);
  double number(std::string_view key, Limits limits = {}, std::optional<double> normal = {});
  uint64_t count(std::string_view key, uint64_t least, uint64_t most, std::optional<uint64_t> normal = {});
  glm::dvec3 vector(std::string_view key, Limits limits = {});
  // "key": 3 or "key": [2, 4]
  Interval interval(std::string_view key, Limits limits = {}, std::optional<Interval> normal = {});
  // "key": 3 or "key": [2, 4], whole numbers.
  struct Counts {
    uint64_t low = 0, high = 0;
  };
  Counts counts(std::string_view key, uint64_t most);
  // "key": [1, 2, 3] or "key": [[0, 0, 0], [1, 2, 3]]
  struct Corners {
    glm::dvec3 low{0}, high{0};
  };
  Corners corners(std::string_view key, Limits limits = {});
  std::vector<double> numbers(std::string_view key, size_t least, size_t most, Limits limits = {});
  // Returns the rows of a matrix, concatenated.
  std::vector<double> matrix(std::string_view key, size_t rows, size_t columns);
  std::vector<std::string> texts(std::string_view key);  // one string, or a list of at least one
  Spec object(std::string_view key);
  std::vector<Spec> objects(std::string_view key);  // a list of at least one object

  // Throws if the object has a key that no function above has read.
  void finish() const;

 private:
  const nlohmann::ordered_json* value_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
  std::shared_ptr<MemoryClaim> memory_;  // shared by all elements of the list that objects() returned
};

// Returns a value as messages quote it, shortened.
std::string shown(const nlohmann::ordered_json& value);

}  // namespace latelight::data
