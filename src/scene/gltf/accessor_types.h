// The types that an accessor may have, by the use of its values.
#pragma once

#include <string>
#include <string_view>

#include "scene/gltf/accessor.h"

namespace latelight::scene::gltf {

enum class AccessorUse { Vertices, MorphTarget, Instances, Animation };

// Throws Error(BadInput) if a file may not store values such as "TEXCOORD_0" or "rotation" in elements of this type.
// `name` names the values in the message: "meshes[0].primitives[0].TEXCOORD_0".
void checkType(const Elements& elements, AccessorUse use, std::string_view values, const std::string& name);

}  // namespace latelight::scene::gltf
