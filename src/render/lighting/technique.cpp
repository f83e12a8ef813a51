#include "render/lighting/technique.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <vector>

#include "render/base/registry.h"

namespace latelight::render {

#define TECHNIQUE(name) TechniqueInfo technique_##name();
#include "lighting.inc"
#undef TECHNIQUE

std::span<const TechniqueInfo> techniques() {
  static const std::vector<TechniqueInfo> same = [] {
    std::vector<TechniqueInfo> infos;
    std::ranges::copy_if(allTechniques(), std::back_inserter(infos), std::logical_not(), &TechniqueInfo::traces);
    return infos;
  }();
  return same;
}

std::span<const TechniqueInfo> allTechniques() {
  static const std::vector<TechniqueInfo> all = [] {
    std::vector<TechniqueInfo> infos;
#define TECHNIQUE(folder) infos.push_back(technique_##folder()), infos.back().name = registryName(#folder);
#include "lighting.inc"
#undef TECHNIQUE
    return infos;
  }();
  return all;
}

const TechniqueInfo& findTechnique(std::string_view name) {
  return findByName(allTechniques(), name, "lighting technique");
}

std::string techniquesThatCompute() {
  std::vector<std::string> names;
  for (const TechniqueInfo& technique : techniques())
    if (!technique.draws) names.push_back(technique.name);
  const std::string last = names.back();
  names.pop_back();
  return fmt::format("{} or {}", fmt::join(names, ", "), last);
}

}  // namespace latelight::render
