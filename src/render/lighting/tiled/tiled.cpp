// tiled: a list of lights for each tile of 16 by 16 pixels, by the bounds and the mask of depths of its samples.
#include "render/lighting/light_lists.h"

namespace latelight::render {

TechniqueInfo technique_tiled() {
  return {
      .description = "lights listed for each tile of 16x16 pixels, by its samples' box and 2.5D depth mask",
      .make = [](vk::Device& device, const GpuScene&, const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
        return std::make_unique<LightListsTechnique>(device, setup, LightListsDesc{.name = "tiled"});
      }};
}

}  // namespace latelight::render
