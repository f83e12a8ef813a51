// Rules by which objects are told apart: regular expressions of their nodes' paths, in order.
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

// RE2's syntax. A match takes time linear in the path's length and bounded memory, whatever the expression: paths come
// from scene files of any origin.
class PathRules {
 public:
  // `key` is the format's option, for messages: "categories of the format coco". Throws Error(Usage) for an expression
  // that RE2 refuses, and for one that is too long.
  void add(const std::string& expression, const std::string& key);

  bool empty() const { return expressions_.empty(); }
  // The first rule whose expression is found in the path, by its number.
  std::optional<size_t> find(const std::string& path) const;

 private:
  std::vector<std::shared_ptr<const re2::RE2>> expressions_;
  std::shared_ptr<MemoryClaim> memory_ = std::make_shared<MemoryClaim>();
};

}  // namespace latelight::data
