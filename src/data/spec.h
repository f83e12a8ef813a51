// A part of a job, as the user wrote it: a JSON object that is read strictly. Everything throws Error(Usage) that names
// the key's path, as in "cameras[2].radius".
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

// Beyond, squares leave the range of float.
inline constexpr double kLargest = 1e15;

// Both ends included.
struct Limits {
  double least = -kLargest, most = kLargest;
};
inline constexpr Limits kPositive{std::numeric_limits<double>::min()}, kNotNegative{0};

// What is drawn from, or a single value twice.
struct Interval {
  double low = 0, high = 0;
};

class Spec {
 public:
  // `value` must outlive it.
  Spec(const nlohmann::ordered_json& value, std::string path);

  const std::string& path() const { return path_; }
  std::string pathOf(std::string_view key) const;
  bool has(std::string_view key);
  // The value itself; throws where it is missing.
  const nlohmann::ordered_json& at(std::string_view key);

  // Without a default the key is required.
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
  // Rows of a matrix, one after the other.
  std::vector<double> matrix(std::string_view key, size_t rows, size_t columns);
  std::vector<std::string> texts(std::string_view key);  // one text, or a list of them
  Spec object(std::string_view key);
  std::vector<Spec> objects(std::string_view key);  // at least one

  // Throws for a key that nothing has asked for.
  void finish() const;

 private:
  const nlohmann::ordered_json* value_;
  std::string path_;
  std::set<std::string, std::less<>> known_;
  std::shared_ptr<MemoryClaim> memory_;  // of the list that it is in
};

// A value as it is repeated in a message.
std::string shown(const nlohmann::ordered_json& value);

}  // namespace latelight::data
