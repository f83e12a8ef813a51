// tiled: a light list for each tile of 16 by 16 pixels, by the bounds and the depth mask of its samples.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_tiled() {
  return {.description = "deferred: light lists per 16x16 tile, by the bounding box and 2.5D depth mask of its samples",
          .add = [](const FrameContext& f, Gbuffer& gbuffer) { addLightLists(f, gbuffer, {.name = "tiled"}); }};
}

}  // namespace latelight::render
