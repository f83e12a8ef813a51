// The table of light types.
#include "scene/light_types.h"

#include <algorithm>

#include "scene/scene.h"
#include "shared/light.h"

namespace latelight::scene {

constinit const uint32_t kPointLight = shared::kLightPoint;

std::span<const LightType> lightTypes() {
#define TYPE(name, index) {#name, LIGHT_DESCRIPTION_##name},
  static constexpr LightType kTypes[] = {LATELIGHT_LIGHTS(TYPE)};
#undef TYPE
  return kTypes;
}

std::optional<uint32_t> findLightType(std::string_view name) {
  const auto found = std::ranges::find(lightTypes(), name, &LightType::name);
  if (found == lightTypes().end()) return std::nullopt;
  return static_cast<uint32_t>(found - lightTypes().begin());
}

}  // namespace latelight::scene
