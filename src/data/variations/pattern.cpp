#include "data/variations/pattern.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>

#include "base/error.h"

namespace latelight::data {

namespace {

bool fits(const std::vector<std::string>& patterns, const std::string& name) {
  return std::ranges::any_of(
      patterns, [&](const std::string& pattern) { return fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0; });
}

template <typename Fits>
std::vector<uint32_t> selectFrom(Spec& spec, std::string_view key, const scene::Scene& scene, size_t count,
                                 std::string_view what, const Fits& fitsAt) {
  std::vector<uint32_t> selected;
  for (uint32_t i = 0; i < count; ++i)
    if (fitsAt(i)) selected.push_back(i);
  if (selected.empty())
    badUsage("{}: {} has no {} of that name", spec.has(key) ? spec.pathOf(key) : spec.path(), scene.source, what);
  return selected;
}

std::vector<std::string> patternsOf(Spec& spec, std::string_view key) {
  return spec.has(key) ? spec.texts(key) : std::vector<std::string>{"*"};
}

}  // namespace

std::vector<uint32_t> selectMaterials(Spec& spec, std::string_view key, const scene::Scene& scene) {
  const std::vector<std::string> patterns = patternsOf(spec, key);
  return selectFrom(spec, key, scene, scene.materials.size(), "material",
                    [&](uint32_t i) { return fits(patterns, scene.materials[i].name); });
}

std::vector<uint32_t> selectLights(Spec& spec, std::string_view key, const scene::Scene& scene) {
  const std::vector<std::string> patterns = patternsOf(spec, key);
  return selectFrom(spec, key, scene, scene.lights.size(), "light",
                    [&](uint32_t i) { return !scene.lights[i].removed && fits(patterns, scene.lights[i].name); });
}

std::vector<uint32_t> selectNodes(Spec& spec, std::string_view key, const scene::Scene& scene) {
  const std::vector<std::string> patterns = spec.texts(key);
  return selectFrom(spec, key, scene, scene.nodes.size(), "node", [&](uint32_t i) {
    const scene::Node& node = scene.nodes[i];
    return !node.path.empty() && (fits(patterns, node.name) || fits(patterns, node.path));
  });
}

std::vector<std::vector<uint32_t>> selectedAbove(const scene::Scene& scene, const std::vector<uint32_t>& nodes) {
  std::vector<bool> selected(scene.nodes.size());
  for (const uint32_t node : nodes) selected[node] = true;
  std::vector<std::vector<uint32_t>> above(scene.instances.size());
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].removed) continue;
    for (int at = static_cast<int>(scene.instances[i].node); at >= 0; at = scene.nodes[static_cast<size_t>(at)].parent)
      if (selected[static_cast<size_t>(at)]) above[i].push_back(static_cast<uint32_t>(at));
  }
  return above;
}

}  // namespace latelight::data
