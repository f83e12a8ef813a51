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
    {"api", {"base", "shared", "scene", "output", "render", "latelight"}},
    {"study", {"base", "vk", "graph", "shared", "scene", "output", "render", "latelight"}},
    {"report", {"base", "vk", "shared", "scene", "output", "render", "study"}},
    {"data", {"base", "vk", "shared", "scene", "output", "render", "latelight"}},
    {"view", {"base", "vk", "graph", "shared", "scene", "output", "render", "latelight"}},
    {"serve", {"base", "graph", "output", "render", "view", "latelight"}},
    {"app",
     {"base", "vk", "graph", "shared", "scene", "output", "render", "study", "report", "data", "view", "serve",
      "latelight"}},
    {"include", {"latelight"}},
};
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

// By the first that a path begins with.
struct Layer {
  std::string_view begins;
  int height;
};
constexpr Layer kLayersOfRender[] = {
    {"render/frame/constant_ids.", 0},
    {"render/frame/constants.", 0},
    {"render/frame/pixel_group.", 0},
    {"render/frame/registry.", 0},
    {"render/frame/pass.", 0},
    {"render/frame/frustum.", 0},
    {"render/frame/view.", 0},
    {"render/frame/texture_kinds.", 0},
    {"render/submit/readback.", 0},
    {"render/gpu_scene/", 1},
    {"render/deform/", 1},
    {"render/settings/", 2},
    {"render/frame/", 2},
    {"render/gbuffer/", 2},
    {"render/lens/", 2},
    {"render/visibility/", 2},
    {"render/layered/", 2},
    {"render/lighting/", 2},
    {"render/shadow/", 2},
    {"render/transparency/", 2},
    {"render/post/", 2},
    {"render/outputs/", 2},
    {"render/submit/view_set.", 3},
    {"render/submit/strips.", 3},
    {"render/submit/request.", 3},
    {"render/", 4},
};

int heightInRender(std::string_view path) {
  for (const Layer& layer : kLayersOfRender)
    if (path.starts_with(layer.begins)) return layer.height;
  return -1;  // not of render
}

}  // namespace

std::vector<std::string> includesFromAbove(std::string_view path, std::string_view text) {
  std::vector<std::string> above;
  for (const Include& include : includesIn(text))
    if (heightInRender(include.path) > heightInRender(path)) above.push_back(include.path);
  return above;
}

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
  const auto allowed = kAllowed.find(folder);
  if (allowed == kAllowed.end()) return {"a folder without a rule"};
  std::vector<std::string> wrong;
  for (const auto& [path, quoted] : includesIn(text)) {
    if (isVulkan(path) && !kMayUseVulkan.contains(folder)) wrong.push_back(path + " (Vulkan)");
    const std::string first = path.substr(0, path.find('/'));
    const bool ours = quoted || first == "latelight";
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
