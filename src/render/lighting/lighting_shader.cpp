#include "render/lighting/lighting_shader.h"

#include "render/lit_maps.h"

namespace latelight::render {

size_t gbufferInputs(const FrameSetup& setup) {
  return setup.layout->targets.size() + (setup.samples > 1 ? 3 : 1);  // depth; light of samples, surfaces
}

std::vector<graph::ImageId> gbufferInputs(const Gbuffer& gbuffer) {
  std::vector<graph::ImageId> images = gbuffer.targets;
  images.push_back(gbuffer.sampleDepth);
  if (gbuffer.surfaces) images.insert(images.end(), {gbuffer.sampleLight, gbuffer.surfaces});
  return images;
}

LightingShader::LightingShader(vk::Device& device, const FrameSetup& setup, const std::string& file,
                               const std::vector<vk::Constant>& own, const std::vector<vk::Binding>& more) {
  vk::ComputeDesc desc;
  desc.shader = setup.variant(file + "@" + setup.layout->file);
  desc.bindings.assign(gbufferInputs(setup), vk::Binding::Sampled);
  desc.bindings.insert(desc.bindings.end(), 2, vk::Binding::Storage);  // light, counts
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
  for (graph::ImageId image : gbufferInputs(gbuffer)) accesses.emplace_back(image, graph::Use::SampledCompute);
  accesses.emplace_back(gbuffer.light, gbuffer.surfaces ? graph::Use::StorageWrite : graph::Use::StorageReadWrite);
  accesses.emplace_back(gbuffer.lightCounts, graph::Use::StorageWrite);
  appendLitAccesses(accesses, gbuffer, graph::Use::SampledCompute);
  return accesses;
}

std::vector<vk::BoundImage> LightingShader::images(graph::Context& context, const FrameInputs& inputs,
                                                   const Gbuffer& gbuffer) const {
  std::vector<vk::BoundImage> images;
  for (graph::ImageId image : gbufferInputs(gbuffer))
    images.push_back({context.image(image).arrayView(), sampler_.get()});
  images.push_back({context.image(gbuffer.light).arrayView()});
  images.push_back({context.image(gbuffer.lightCounts).arrayView()});
  appendLitImages(images, context, inputs, gbuffer);
  return images;
}

}  // namespace latelight::render
