#include "architecture/include_rules.h"

#include <map>
#include <regex>
#include <set>

namespace latelight {
namespace {

// Beside itself, a folder may include these. "latelight": the public headers, which also say what an error is.
const std::map<std::string, std::set<std::string>, std::less<>> kAllowed = {
    {"base", {"latelight"}},
    {"shared", {}},
    {"vk", {"base"}},
    {"graph", {"base", "vk"}},
    {"scene", {"base", "shared"}},
    {"output", {"base", "shared", "scene"}},
    {"render", {"base", "vk", "graph", "shared", "scene", "output", "latelight"}},
    {"study", {"base", "vk", "graph", "shared", "scene", "output", "render", "latelight"}},
    {"app", {"base", "vk", "graph", "shared", "scene", "output", "render", "study", "latelight"}},
    {"include", {"latelight"}},
};
const std::set<std::string, std::less<>> kMayUseVulkan = {"vk", "graph", "render", "study"};

bool isVulkan(const std::string& path) {
  return path == "volk.h" || path.starts_with("vulkan/");
}

}  // namespace

std::vector<std::string> wrongIncludes(std::string_view folder, std::string_view text,
                                       const std::function<bool(const std::string&)>& isGenerated) {
  const auto allowed = kAllowed.find(folder);
  if (allowed == kAllowed.end()) return {"a folder without a rule"};
  static const std::regex include(R"re(^[ \t]*#[ \t]*include[ \t]*(["<])([^">]+)[">])re", std::regex::multiline);
  std::vector<std::string> wrong;
  const std::string copy(text);
  for (std::sregex_iterator it(copy.begin(), copy.end(), include), end; it != end; ++it) {
    const std::string path = (*it)[2];
    if (isVulkan(path) && !kMayUseVulkan.contains(folder)) wrong.push_back(path + " (Vulkan)");
    const std::string first = path.substr(0, path.find('/'));
    const bool ours = (*it)[1] == "\"" || first == "latelight";
    if (!ours || isGenerated(path)) continue;
    if (first == path) {
      wrong.push_back(path + " (a path from src/ is clear, this is not)");
    } else if (first != folder && !allowed->second.contains(first)) {
      wrong.push_back(path);
    }
  }
  return wrong;
}

}  // namespace latelight
