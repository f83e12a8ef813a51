// tiled: tiled light culling (Andersson 2009, Parallel Graphics in Frostbite, SIGGRAPH course; Harada 2012, A 2.5D
// Culling for Forward+, SIGGRAPH Asia technical briefs). Each tile of 16x16 pixels has a light list, culled by the
// bounding box and the depth mask of its samples.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_tiled() {
  return {.description = "deferred: light lists per 16x16 tile, by the bounding box and 2.5D depth mask of its samples",
          .add = [](const FrameContext& f, const Gbuffer& gbuffer) {
            return addLightLists(f, gbuffer, {.name = "tiled"});
          }};
}

}  // namespace latelight::render
