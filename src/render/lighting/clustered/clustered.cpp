// clustered: a light list for each depth slice of each tile, by the bounds of the samples in it.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_clustered() {
  return {.description = "deferred: light lists per depth slice of each tile, by the bounding box of its samples",
          .add = [](const FrameContext& f, Gbuffer& gbuffer) {
            addLightLists(f, gbuffer, {.name = "clustered", .cellsATile = kSlices});
          }};
}

}  // namespace latelight::render
