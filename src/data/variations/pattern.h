// Selects elements of a scene by name, with the wildcards * and ? of a shell.
#pragma once

#include <string>
#include <vector>

#include "data/spec.h"
#include "scene/scene.h"

namespace latelight::data {

// Return the indices of the elements that match any of a key's patterns, or of all elements if the key is missing.
// Throw Error(Usage) if there is none.
std::vector<uint32_t> selectMaterials(Spec& spec, std::string_view key, const scene::Scene& scene);
std::vector<uint32_t> selectLights(Spec& spec, std::string_view key, const scene::Scene& scene);
// Selects nodes by name or path. The key is required.
std::vector<uint32_t> selectNodes(Spec& spec, std::string_view key, const scene::Scene& scene);

// Returns for each instance the selected nodes among its own node and that node's ancestors, in this order.
std::vector<std::vector<uint32_t>> selectedAbove(const scene::Scene& scene, const std::vector<uint32_t>& nodes);

}  // namespace latelight::data
