#include "render/post/ambient_occlusion/ambient_occlusion.h"

#include <span>

#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

// Beyond this share of the picture's height, samples would lie so far apart that they miss what is between them.
constexpr float kReachShare = 0.5f;
// Of the radius: pixels that far off each other's plane share no occlusion.
constexpr float kToleranceShare = 0.3f;

struct OcclusionPush {  // gtao.glsl
  VkDeviceAddress frame;
  float radius, reach;
};

struct DenoisePush {  // ambient_occlusion_denoise.comp
  VkDeviceAddress frame;
  float tolerance, strength;
};

// Forward techniques leave no normals, and several samples a pixel no single one: they come from depth then.
bool readsNormals(const FrameSetup& setup) {
  return !setup.lighting->forward && setup.samples == 1;
}

vk::Pipeline makeOcclusion(vk::Device& device, const FrameSetup& setup) {
  vk::ComputeDesc desc{.shader = "gtao_depth.comp", .name = "ambient occlusion"};
  if (readsNormals(setup)) {
    desc.shader = "gtao.comp@" + setup.layout->file;
    desc.bindings.assign(setup.layout->targets.size(), vk::Binding::Sampled);
  }
  desc.bindings.insert(desc.bindings.end(), {vk::Binding::Sampled, vk::Binding::Storage});  // depth, result
  desc.constants = setup.constants();
  return vk::makePipeline(device, desc);
}

vk::Pipeline makeDenoise(vk::Device& device, uint32_t axis) {
  return vk::makePipeline(
      device, vk::ComputeDesc{.shader = "ambient_occlusion_denoise.comp",
                              .bindings = {vk::Binding::Sampled, vk::Binding::Sampled, vk::Binding::Storage},
                              .constants = {{kFirstOwnConstant, axis}},
                              .name = "ambient occlusion denoise"});
}

}  // namespace

AmbientOcclusionPass::AmbientOcclusionPass(vk::Device& device, const FrameSetup& setup)
    : readsNormals_(readsNormals(setup)), sampler_(vk::makeSampler(device, vk::kNearestSampler)) {
  if (setup.ambientOcclusion == kAoNone) {
    none_ = vk::Image(device, {.format = kAoFormat,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .name = "no ambient occlusion"});
    const float visible = 1;
    vk::Uploader(device).upload(none_, std::as_bytes(std::span(&visible, 1)));
    return;
  }
  occlusion_ = makeOcclusion(device, setup);
  for (uint32_t axis = 0; axis < 2; ++axis) denoise_[axis] = makeDenoise(device, axis);
}

graph::ImageId AmbientOcclusionPass::add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const {
  if (none_) return graph.import(none_, graph::Use::SampledCompute);
  const graph::ImageId hidden = createTarget(graph, inputs, kAoFormat, "hidden");
  const graph::ImageId across = createTarget(graph, inputs, kAoFormat, "hidden, averaged across");
  const graph::ImageId visible = createTarget(graph, inputs, kAoFormat, "ambient occlusion");
  addOcclusion(graph, inputs, gbuffer, hidden);
  addDenoise(graph, inputs, gbuffer.depth, {hidden, across}, 0);
  addDenoise(graph, inputs, gbuffer.depth, {across, visible}, 1);
  return visible;
}

void AmbientOcclusionPass::addOcclusion(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer,
                                        graph::ImageId hidden) const {
  std::vector<graph::ImageId> sources;
  if (readsNormals_) sources = gbuffer.targets;
  sources.push_back(gbuffer.depth);
  std::vector<graph::Access> accesses{{hidden, graph::Use::StorageWrite}};
  for (graph::ImageId source : sources) accesses.emplace_back(source, graph::Use::SampledCompute);
  graph.pass(graph::Stage::Lighting, "ambient occlusion", std::move(accesses), [=, this](graph::Context& context) {
    std::vector<vk::BoundImage> images;
    for (graph::ImageId source : sources) images.push_back({context.image(source).arrayView(), sampler_.get()});
    images.push_back({context.image(hidden).arrayView()});
    const OcclusionPush push{inputs.constants, inputs.aoRadius, kReachShare * static_cast<float>(inputs.height)};
    context.commands().bind(occlusion_, images, push);
    context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16, 16);
  });
}

void AmbientOcclusionPass::addDenoise(graph::Graph& graph, const FrameInputs& inputs, graph::ImageId depth,
                                      std::array<graph::ImageId, 2> hiddenAndResult, uint32_t axis) const {
  const auto [hidden, result] = hiddenAndResult;
  graph.pass(
      graph::Stage::Lighting, "ambient occlusion denoise",
      {{depth, graph::Use::SampledCompute}, {hidden, graph::Use::SampledCompute}, {result, graph::Use::StorageWrite}},
      [=, this](graph::Context& context) {
        context.commands().bind(denoise_[axis],
                                {{context.image(depth).arrayView(), sampler_.get()},
                                 {context.image(hidden).arrayView(), sampler_.get()},
                                 {context.image(result).arrayView()}},
                                DenoisePush{inputs.constants, kToleranceShare * inputs.aoRadius, inputs.aoStrength});
        context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16, 16);
      });
}

}  // namespace latelight::render
