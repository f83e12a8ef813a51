#include "render/lighting/reference/emitter_sums.h"

#include <algorithm>

#include "render/lighting/reference/emitters_push.h"

namespace latelight::render {

graph::BufferId addEmitterSums(const FrameContext& f) {
  const auto lists = f.scene.hasWorlds() ? static_cast<uint32_t>(f.views.size()) : 1u;
  const graph::BufferId sums =
      f.graph.create(vk::BufferDesc{.size = uint64_t{lists} * f.emitters * sizeof(float), .name = "emitter powers"});
  const auto push = [constants = f.constants, stride = f.emitters, sums](graph::Context& context) {
    return shared::EmittersPush{
        .frame = constants, .sums = context.buffer(sums).address(), .stride = stride, .padding = 0};
  };
  constexpr uint32_t kGroup = 64, kRow = 32768 * kGroup;  // invocations per row of a dispatch
  ComputePass powers{.stage = graph::Stage::Lighting,
                     .name = "emitter powers",
                     .shader = "emitter_powers.comp",
                     .bindings = Bindings(f.device),
                     .size = {std::min(f.emitters, kRow), (f.emitters + kRow - 1) / kRow, lists},
                     .buffers = {{sums, graph::Use::StorageWrite}},
                     .groupX = kGroup,
                     .groupY = 1};
  addCompute(f, std::move(powers), push);
  ComputePass running{.stage = graph::Stage::Lighting,
                      .name = "emitter sums",
                      .shader = "emitter_sums.comp",
                      .bindings = Bindings(f.device),
                      .size = {1, 1, lists},
                      .buffers = {{sums, graph::Use::StorageReadWrite}},
                      .groupX = 256,
                      .groupY = 1};
  addCompute(f, std::move(running), push);
  return sums;
}

}  // namespace latelight::render
