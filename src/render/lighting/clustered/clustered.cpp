// clustered: a light list for each depth slice of each tile, by the bounds of the samples in it.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_clustered() {
  return {.description = "lights listed for each depth slice of each tile, by the box of the samples in it",
          .add = [](const FrameContext& f, Gbuffer& gbuffer) {
            addLightLists(f, gbuffer, {.name = "clustered", .cellsATile = kSlices});
          }};
}

}  // namespace latelight::render
