#include "data/formats/path_rules.h"

#include <re2/re2.h>

#include "base/error.h"

namespace latelight::data {

namespace {

// RE2 writes to standard error for expressions much longer than this.
constexpr size_t kLongest = 10'000;
constexpr int64_t kMemory = 1 << 20;  // bytes per expression, including RE2's cache for matching

}  // namespace

void PathRules::add(const std::string& expression, const std::string& key) {
  if (expression.size() > kLongest)
    badUsage("{} has \"{}\", which is longer than {} bytes: use several shorter ones", key, expression, kLongest);
  memory_->grow(kMemory, "regular expressions");
  re2::RE2::Options options;
  options.set_log_errors(false);
  options.set_max_mem(kMemory);
  auto compiled = std::make_shared<re2::RE2>(expression, options);
  if (!compiled->ok())
    badUsage(
        "{} has \"{}\", which is no regular expression in RE2's syntax ({}): see "
        "https://github.com/google/re2/wiki/Syntax",
        key, expression, compiled->error());
  expressions_.push_back(std::move(compiled));
}

std::optional<size_t> PathRules::find(const std::string& path) const {
  for (size_t i = 0; i < expressions_.size(); ++i)
    if (re2::RE2::PartialMatch(path, *expressions_[i])) return i;
  return std::nullopt;
}

}  // namespace latelight::data
