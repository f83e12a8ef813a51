// interlaced: first the even rows, then the odd ones, as televisions drew them. A pass over half a picture takes half
// as long, so that a device which cuts off long dispatches lights twice as many lights.
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

struct FieldPush {  // interlaced.comp
  VkDeviceAddress frame;
  uint32_t firstRow;
};

class Interlaced final : public LightingTechnique {
 public:
  Interlaced(vk::Device& device, const FrameSetup& setup) : shader_(device, setup, "interlaced.comp") {}

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    graph.pass(graph::Stage::Lighting, "lighting interlaced", LightingShader::accesses(gbuffer),
               [this, inputs, gbuffer](graph::Context& context) {
                 for (uint32_t row : {0u, 1u}) {  // no pixel is in both, so nothing has to wait
                   FrameInputs field = inputs;
                   field.height = (inputs.height + 1 - row) / 2;
                   if (field.height) shader_.dispatch(context, field, gbuffer, FieldPush{inputs.constants, row});
                 }
               });
  }

 private:
  LightingShader shader_;
};

}  // namespace

TechniqueInfo technique_interlaced() {
  return {
      .description = "the even rows of the picture, then the odd ones; every light at every pixel",
      .make = [](vk::Device& device, const GpuScene&, const FrameSetup& setup) -> std::unique_ptr<LightingTechnique> {
        return std::make_unique<Interlaced>(device, setup);
      }};
}

}  // namespace latelight::render
