// clustered: a list of lights for each slice of depth of each tile, by the bounds of the samples in it.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_clustered() {
  return {
      .description = "lights listed for each depth slice of each tile, by the box of the samples in it",
      .make = [](vk::Device& device, const GpuScene&, const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
        return std::make_unique<LightListsTechnique>(device, setup,
                                                     LightListsDesc{.name = "clustered", .cellsATile = kSlices});
      }};
}

}  // namespace latelight::render
