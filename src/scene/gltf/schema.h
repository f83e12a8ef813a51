// Validates the JSON of a glTF 2.0 file before it is read, because its readers trust types, indices and ranges.
#pragma once

#include <nlohmann/json.hpp>

namespace latelight::scene::gltf {

// Checks every property that this importer reads, core and extensions: types, ranges, array lengths, and that each
// index is within its array. Integers written as 3.0 become integers. Unknown properties are allowed. Throws
// Error(BadInput) with the property's path, as in "accessors[3].count is missing".
void validate(nlohmann::json& root);

}  // namespace latelight::scene::gltf
