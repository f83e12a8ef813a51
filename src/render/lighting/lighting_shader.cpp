#include "render/lighting/lighting_shader.h"

#include "render/lit_maps.h"

namespace latelight::render {

LightingShader::LightingShader(vk::Device& device, const FrameSetup& setup, const std::string& file,
                               const std::vector<vk::Constant>& own, const std::vector<vk::Binding>& more) {
  vk::ComputeDesc desc;
  desc.shader = file + "@" + setup.layout->file;
  desc.bindings.assign(setup.layout->targets.size() + 1, vk::Binding::Sampled);  // and depth
  desc.bindings.insert(desc.bindings.end(), 2, vk::Binding::Storage);            // light, counts
  appendLitBindings(desc.bindings);
  desc.bindings.insert(desc.bindings.end(), more.begin(), more.end());
  desc.constants = setup.constants();
  desc.constants.insert(desc.constants.end(), own.begin(), own.end());
  desc.name = desc.shader;
  pipeline_ = vk::makePipeline(device, desc);
  sampler_ = vk::makeSampler(device, vk::kNearestSampler);
}

std::vector<graph::Access> LightingShader::accesses(const Gbuffer& gbuffer) {
  std::vector<graph::Access> accesses;
  for (graph::ImageId target : gbuffer.targets) accesses.emplace_back(target, graph::Use::SampledCompute);
  accesses.emplace_back(gbuffer.depth, graph::Use::SampledCompute);
  accesses.emplace_back(gbuffer.light, graph::Use::StorageReadWrite);
  accesses.emplace_back(gbuffer.lightCounts, graph::Use::StorageWrite);
  appendLitAccesses(accesses, gbuffer, graph::Use::SampledCompute);
  return accesses;
}

std::vector<vk::BoundImage> LightingShader::images(graph::Context& context, const FrameInputs& inputs,
                                                   const Gbuffer& gbuffer) const {
  std::vector<vk::BoundImage> images;
  for (graph::ImageId target : gbuffer.targets) images.push_back({context.image(target).arrayView(), sampler_.get()});
  images.push_back({context.image(gbuffer.depth).arrayView(), sampler_.get()});
  images.push_back({context.image(gbuffer.light).arrayView()});
  images.push_back({context.image(gbuffer.lightCounts).arrayView()});
  appendLitImages(images, context, inputs, gbuffer);
  return images;
}

}  // namespace latelight::render
