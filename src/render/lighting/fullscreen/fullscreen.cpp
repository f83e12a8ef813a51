// fullscreen: one compute pass over the picture, every light at every pixel. O(pixels x lights), and the reference that
// every other technique is compared with.
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

struct LightingPush {  // fullscreen.comp
  VkDeviceAddress frame;
};

class Fullscreen final : public LightingTechnique {
 public:
  Fullscreen(vk::Device& device, const FrameSetup& setup) {
    vk::ComputeDesc desc;
    desc.shader = "fullscreen.comp@" + setup.layout->file;
    desc.bindings.assign(setup.layout->targets.size() + 1, vk::Binding::Sampled);  // targets, depth
    desc.bindings.push_back(vk::Binding::Storage);                                 // light
    desc.bindings.insert(desc.bindings.end(), GpuEnvironment::kBindings, vk::Binding::Sampled);
    desc.constants = {{0, setup.normalEncoding}, {1, setup.shading}};
    desc.name = "lighting fullscreen " + setup.layout->name;
    pipeline_ = vk::makePipeline(device, desc);
    sampler_ = vk::makeSampler(device, vk::kNearestSampler);
  }

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    std::vector<graph::Access> accesses;
    for (graph::ImageId target : gbuffer.targets) accesses.emplace_back(target, graph::Use::SampledCompute);
    accesses.emplace_back(gbuffer.depth, graph::Use::SampledCompute);
    accesses.emplace_back(gbuffer.light, graph::Use::StorageReadWrite);
    graph.pass("lighting fullscreen", std::move(accesses), [this, inputs, gbuffer](graph::Context& context) {
      std::vector<vk::BoundImage> images;
      for (graph::ImageId target : gbuffer.targets)
        images.push_back({context.image(target).arrayView(), sampler_.get()});
      images.push_back({context.image(gbuffer.depth).arrayView(), sampler_.get()});
      images.push_back({context.image(gbuffer.light).arrayView()});
      for (const vk::BoundImage& map : inputs.environment.bindings()) images.push_back(map);
      context.commands().bind(pipeline_, images, LightingPush{inputs.constants});
      context.commands().dispatch(inputs.width, inputs.height, static_cast<uint32_t>(inputs.views.size()), 16, 16);
    });
  }

 private:
  vk::Pipeline pipeline_;
  vk::Handle<VkSampler> sampler_;
};

}  // namespace

TechniqueInfo technique_fullscreen() {
  return {.description = "one pass over the picture, every light at every pixel",
          .make = [](vk::Device& device, const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
            return std::make_unique<Fullscreen>(device, setup);
          }};
}

}  // namespace latelight::render
