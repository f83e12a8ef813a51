// Classifies objects by an ordered list of regular expressions that are matched with the paths of their nodes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/memory.h"

namespace re2 {
class RE2;
}

namespace latelight::data {

// Expressions have RE2's syntax. For any expression, RE2 matches in time linear in the path's length and in bounded
// memory. This matters because paths come from untrusted scene files.
class PathRules {
 public:
  // `key` names the format's option in messages: "categories of the format coco". Throws Error(Usage) for an expression
  // that RE2 rejects or that is too long.
  void add(const std::string& expression, const std::string& key);

  bool empty() const { return expressions_.empty(); }
  // Returns the index of the first rule whose expression matches a part of the path.
  std::optional<size_t> find(const std::string& path) const;

 private:
  std::vector<std::shared_ptr<const re2::RE2>> expressions_;
  std::shared_ptr<MemoryClaim> memory_ = std::make_shared<MemoryClaim>();
};

}  // namespace latelight::data
