// The lights that a technique goes through, and those that it needed, as the renderer counts them.
#pragma once

#include "render/submit/renderer.h"

namespace latelight::study {

struct LightCounts {  // means over all pixels
  double tested, used;
};
LightCounts countLights(render::Renderer& renderer, const scene::Camera& camera, const render::Moment& moment,
                        render::Settings settings);

}  // namespace latelight::study
