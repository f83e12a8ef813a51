#include "render/post/ground/ground.h"

#include <algorithm>

#include "render/post/ground/ground_push.h"

namespace latelight::render {

namespace {

// Samples per pass, of two rays each. Images of environments differ in size, so each has passes of its own. lavapipe
// silently ends a shader's loops after 65535 iterations in total, and a ray visits about a hundred nodes; drivers of
// GPUs end passes that take seconds.
constexpr uint32_t kSamplesAtOnce = 64;

}  // namespace

void addGround(const FrameContext& f, const Gbuffer& gbuffer, GroundOrder order) {
  const uint32_t all = f.setup.paths;
  vk::ImageDesc sumDesc{.format = VK_FORMAT_R32G32B32A32_SFLOAT, .width = 1, .height = 1, .name = "no sum of ground"};
  const bool sums = all > kSamplesAtOnce;
  const graph::ImageId sum = sums ? createTarget(f, sumDesc.format, "sum of ground") : f.graph.create(sumDesc);
  for (uint32_t first = 0; first < all; first += kSamplesAtOnce)
    for (uint32_t environment = 0; environment < f.environment.count(); ++environment) {
      Bindings bindings(f.device);
      bindings.sampled(gbuffer.depth);
      bindings.storage(gbuffer.light, graph::Use::StorageReadWrite).outside(f.environment.radiance(environment));
      bindings.storage(sum, first + environment > 0 ? graph::Use::StorageReadWrite : graph::Use::StorageWrite);
      addCompute(f,
                 {.stage = graph::Stage::Post,
                  .name = "ground",
                  .shader = "ground.comp",
                  .bindings = std::move(bindings),
                  .size = f.pixels(),
                  .constants = f.setup.constants()},
                 shared::GroundPush{.frame = f.constants,
                                    .height = f.groundHeight,
                                    .first = first,
                                    .end = std::min(first + kSamplesAtOnce, all),
                                    .samples = all,
                                    .environment = environment,
                                    .coversBlended = order == GroundOrder::OverPicture ? 1u : 0u});
    }
}

}  // namespace latelight::render
