#include "render/lit_maps.h"

namespace latelight::render {

void appendLitBindings(std::vector<vk::Binding>& bindings) {
  bindings.insert(bindings.end(), kLitMaps, vk::Binding::Sampled);
}

void appendLitAccesses(std::vector<graph::Access>& accesses, const Gbuffer& gbuffer, graph::Use use) {
  if (gbuffer.shadows) accesses.emplace_back(gbuffer.shadows, use);
  accesses.emplace_back(gbuffer.ambientOcclusion, use);
}

void appendLitImages(std::vector<vk::BoundImage>& images, graph::Context& context, const FrameInputs& inputs,
                     const Gbuffer& gbuffer) {
  const std::vector<vk::BoundImage> environment = inputs.environment.bindings();
  images.insert(images.end(), environment.begin(), environment.end());
  // Something must be bound where there are no shadows too; it is never read.
  images.push_back({gbuffer.shadows ? context.image(gbuffer.shadows).view() : environment.front().view,
                    inputs.environment.fetchSampler()});
  images.push_back({context.image(gbuffer.ambientOcclusion).arrayView(), inputs.environment.fetchSampler()});
}

}  // namespace latelight::render
