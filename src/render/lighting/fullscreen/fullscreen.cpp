// fullscreen: one compute pass over the picture, every light at every pixel. O(pixels x lights), and the reference that
// every other technique is compared with.
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

struct LightingPush {  // fullscreen.comp
  VkDeviceAddress frame;
};

class Fullscreen final : public LightingTechnique {
 public:
  Fullscreen(vk::Device& device, const FrameSetup& setup) : shader_(device, setup, "fullscreen.comp") {}

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    graph.pass("lighting fullscreen", LightingShader::accesses(gbuffer),
               [this, inputs, gbuffer](graph::Context& context) {
                 shader_.dispatch(context, inputs, gbuffer, LightingPush{inputs.constants});
               });
  }

 private:
  LightingShader shader_;
};

}  // namespace

TechniqueInfo technique_fullscreen() {
  return {
      .description = "one pass over the picture, every light at every pixel",
      .make = [](vk::Device& device, const GpuScene&, const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
        return std::make_unique<Fullscreen>(device, setup);
      }};
}

}  // namespace latelight::render
