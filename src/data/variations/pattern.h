// Elements of a scene by their names, with * and ? as in a shell.
#pragma once

#include <string>
#include <vector>

#include "data/spec.h"
#include "scene/scene.h"

namespace latelight::data {

// The numbers of those that a key's pattern, or one of its patterns, selects; all of them where the key is missing.
// Throw Error(Usage) where there is none.
std::vector<uint32_t> selectMaterials(Spec& spec, std::string_view key, const scene::Scene& scene);
std::vector<uint32_t> selectLights(Spec& spec, std::string_view key, const scene::Scene& scene);
// By name or by path; the key is required.
std::vector<uint32_t> selectNodes(Spec& spec, std::string_view key, const scene::Scene& scene);

// By instance: the selected nodes that it is at or below, from its own upwards.
std::vector<std::vector<uint32_t>> selectedAbove(const scene::Scene& scene, const std::vector<uint32_t>& nodes);

}  // namespace latelight::data
