// Area lights in the extras of nodes:
//
//   "extras": {"areaLight": {"type": "rect", "color": [1, 1, 1], "intensity": 1000, "size": 0.5,
//              "rect": {"aspect": 2}, "twoSided": false, "castShadow": true, "name": "ceiling"}}
//
// The properties are those of a light of the draft extension EXT_lights_area: `type` rect or disk, `intensity` in nits,
// and `size`, which is the height of a rectangle or the diameter of a disk. The types sphere and tube (with
// "tube": {"length": 1}), `twoSided` and `castShadow` are not part of the draft.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "scene/scene.h"

namespace latelight::scene::gltf {

// Reads a light, which is not placed yet. Returns null, with a warning that names `path`, if a value is invalid.
std::optional<Light> readAreaLight(const nlohmann::json& source, const std::string& path);

}  // namespace latelight::scene::gltf
