// clustered: clustered light culling (Olsson, Billeter and Assarsson 2012, Clustered Deferred and Forward Shading,
// HPG). Each cluster, which is a depth slice of a 16x16 tile, has a light list, culled by the bounding box of its
// samples.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_clustered() {
  return {.description = "deferred: light lists per depth slice of each tile, by the bounding box of its samples",
          .add = [](const FrameContext& f, const Gbuffer& gbuffer) {
            return addLightLists(f, gbuffer, {.name = "clustered", .cellsPerTile = kSlices});
          }};
}

}  // namespace latelight::render
