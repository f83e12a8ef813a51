#include "render/layered/behind.h"

#include <algorithm>

#include "render/layered/behind_push.h"

namespace latelight::render {

graph::ImageId addTransmissionBackground(const FrameContext& f, graph::ImageId picture) {
  const shared::uvec2 size(f.width, f.height);
  const uint32_t levels = shared::backgroundMips(size);
  const shared::uvec2 last =
      shared::backgroundMipCorner(size, levels - 1) + shared::backgroundMipSize(size, levels - 1);
  // 32-bit floats: some devices truncate to half floats instead of rounding, so a chain of levels would lose light.
  const graph::ImageId behind = f.graph.create(vk::ImageDesc{.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                                             .width = size.x + std::max(size.x / 2, 1u),
                                                             .height = std::max(size.y, last.y),
                                                             .layers = f.viewCount(),
                                                             .name = "behind"});
  for (uint32_t level = 0; level < levels; ++level) {
    const shared::uvec2 texels = shared::backgroundMipSize(size, level);
    Bindings bindings(f.device);
    bindings.sampled(picture);
    bindings.storage(behind, level == 0 ? graph::Use::StorageWrite : graph::Use::StorageReadWrite);
    addCompute(f,
               {.stage = graph::Stage::Transparency,
                .name = "behind",
                .shader = "behind.comp",
                .bindings = std::move(bindings),
                .size = {texels.x, texels.y, f.viewCount()}},
               shared::BackgroundMipPush{level});
  }
  return behind;
}

}  // namespace latelight::render
