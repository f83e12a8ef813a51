#include "architecture/include_rules.h"

#include <regex>
#include <set>

namespace latelight {
namespace {

const std::set<std::string, std::less<>> kMayUseVulkan = {"vk", "graph", "render", "study"};

bool isVulkan(const std::string& path) {
  return path == "volk.h" || path.starts_with("vulkan/");
}

struct Include {
  std::string path;
  bool quoted;
};

std::vector<Include> includesIn(std::string_view text) {
  static const std::regex include(R"re(^[ \t]*#[ \t]*include[ \t]*(["<])([^">]+)[">])re", std::regex::multiline);
  std::vector<Include> includes;
  const std::string copy(text);
  for (std::sregex_iterator it(copy.begin(), copy.end(), include), end; it != end; ++it)
    includes.push_back({(*it)[2], (*it)[1] == "\""});
  return includes;
}

}  // namespace

std::vector<std::string> wayToVulkan(const std::string& text,
                                     const std::function<std::string(const std::string&)>& textOf) {
  std::set<std::string> seen;
  const std::function<std::vector<std::string>(const std::string&)> search = [&](const std::string& from) {
    for (const Include& include : includesIn(from)) {
      if (isVulkan(include.path)) return std::vector{include.path};
      if (!seen.insert(include.path).second) continue;
      std::vector<std::string> way = search(textOf(include.path));
      if (way.empty()) continue;
      way.insert(way.begin(), include.path);
      return way;
    }
    return std::vector<std::string>{};
  };
  return search(text);
}

std::vector<std::string> wrongIncludes(std::string_view folder, std::string_view text,
                                       const std::function<bool(const std::string&)>& isGenerated) {
  std::vector<std::string> wrong;
  for (const auto& [path, quoted] : includesIn(text)) {
    if (isVulkan(path) && !kMayUseVulkan.contains(folder)) wrong.push_back(path + " (Vulkan)");
    if (!quoted || isGenerated(path)) continue;
    if (path.find('/') == path.npos || path.starts_with('.') || path.find("/.") != path.npos)
      wrong.push_back(path + " (a path from src/ is clear, this is not)");
  }
  return wrong;
}

}  // namespace latelight
