#include "render/frame/lit_maps.h"

namespace latelight::render {

void appendLitMaps(Bindings& bindings, const FrameContext& f, const Gbuffer& gbuffer) {
  for (const vk::BoundImage& map : f.environment.bindings()) bindings.outside(map);
  for (const graph::ImageId map : {gbuffer.shadows, gbuffer.ambientOcclusion}) {
    if (map)
      bindings.sampled(map);
    else
      bindings.outside(f.environment.nothing());  // never read, but every binding requires an image
  }
}

}  // namespace latelight::render
