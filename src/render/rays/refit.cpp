#include "render/rays/refit.h"

#include <algorithm>

#include "render/base/constant_ids.h"
#include "shared/rays.h"
#include "vk/device.h"

namespace latelight::render {

vk::PipelineRef refitPipeline(vk::Device& device) {
  return device.cache().pipeline(vk::ComputeDesc{.shader = "ray_refit.comp",
                                                 .constants = {{kFencedConstant, device.isCpu() ? 0u : 1u}},
                                                 .pushBytes = sizeof(shared::RayRefitPush),
                                                 .name = "refit"});
}

void recordRefit(graph::Context& context, const vk::PipelineRef& pipeline, shared::RayRefitPush push, uint32_t worlds) {
  constexpr uint32_t kMaxGroups = 65535;
  for (uint32_t first = 0; first < worlds; first += kMaxGroups) {
    const uint32_t count = std::min(worlds - first, kMaxGroups);
    context.commands().bind(pipeline.get(), {}, push);
    context.commands().dispatch(push.nodeCount, count, 1, 64, 1);
    push.nodes += uint64_t{count} * push.nodeCount * sizeof(shared::RayNode);
    push.mesh += count * push.meshStride;
  }
}

}  // namespace latelight::render
