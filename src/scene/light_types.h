// The light types by name, as glTF names them (shared/light.h).
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "shared/types.h"

namespace latelight::scene {

struct LightType {
  std::string_view name, description;
};

std::span<const LightType> lightTypes();  // indexed by kLight*
std::optional<uint32_t> findLightType(std::string_view name);

}  // namespace latelight::scene
