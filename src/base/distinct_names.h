// Distinct names for elements that may have equal ones.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>

namespace latelight {

class DistinctNames {
 public:
  // Returns the name, or "<name>#<number>" with the lowest number from 2 on, that no earlier call has returned.
  std::string make(const std::string& name) {
    std::string distinct = name;
    for (uint32_t& number = numbers_.try_emplace(name, 1).first->second; !used_.insert(distinct).second;)
      distinct = fmt::format("{}#{}", name, ++number);
    return distinct;
  }

 private:
  std::unordered_map<std::string, uint32_t> numbers_;  // so that a million equal names require only a million steps
  std::unordered_set<std::string> used_;
};

}  // namespace latelight
