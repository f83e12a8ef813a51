// Counts of the lights that a technique tests and of those that contribute, as the renderer outputs them.
#pragma once

#include "render/submit/renderer.h"

namespace latelight::study {

struct LightCounts {  // means over all pixels
  double tested, used;
};
LightCounts countLights(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                        render::Settings settings);

}  // namespace latelight::study
