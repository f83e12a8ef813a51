// tiled: a light list for each tile of 16 by 16 pixels, by the bounds and the depth mask of its samples.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_tiled() {
  return {.description = "lights listed for each tile of 16x16 pixels, by its samples' box and 2.5D depth mask",
          .add = [](const FrameContext& f, Gbuffer& gbuffer) { addLightLists(f, gbuffer, {.name = "tiled"}); }};
}

}  // namespace latelight::render
