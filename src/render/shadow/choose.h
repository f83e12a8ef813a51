// Which lights cast shadows, and how large their maps are.
#pragma once

#include "render/shadow/plan.h"

namespace latelight::render {

struct ShadowCaster {
  uint32_t light;  // among the frame's
  uint32_t maps;   // 1, 6 for a cube, or the number of cascades
  uint32_t size;   // of each map's tile
};

inline constexpr uint32_t kAutomaticShadows = 8;  // lights, where the settings choose automatically

// In the order of their importance. `cascades`: per directional light. All tiles together take at most the square of
// settings.shadowAtlas: local lights' are halved first, then all; finally the least important lights are dropped.
std::vector<ShadowCaster> chooseShadowCasters(const ShadowScene& scene, const shared::View& view,
                                              const Settings& settings, uint32_t cascades);

// The half angle of a spot's map; nothing where the light takes a cube.
std::optional<double> shadowCone(const shared::Light& light);

}  // namespace latelight::render
