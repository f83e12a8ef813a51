// fullscreen: one compute pass over the picture, every light at every pixel. O(pixels x lights), and the reference that
// every other technique is compared with.
#include "base/error.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

struct LightingPush {  // fullscreen.comp
  VkDeviceAddress frame;
};

// lavapipe ends a shader's loops after 65535 rounds, all loops together: two rounds for each subgroup's share of lights
// and one for each light that reaches it. It says nothing, and the other lights are missing.
constexpr uint32_t kMostOnCpu = 200'000;  // for one sample a pixel

class Fullscreen final : public LightingTechnique {
 public:
  Fullscreen(vk::Device& device, const FrameSetup& setup)
      : most_(device.isCpu() ? kMostOnCpu / setup.samples : ~0u), shader_(device, setup, "fullscreen.comp") {}

  void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) const override {
    if (inputs.scene.lightCount() > most_)
      badUsage("fullscreen goes through at most {} lights on a CPU device, and there are {}: choose tiled or clustered",
               most_, inputs.scene.lightCount());
    graph.pass(graph::Stage::Lighting, "lighting fullscreen", LightingShader::accesses(gbuffer),
               [this, inputs, gbuffer](graph::Context& context) {
                 shader_.dispatch(context, inputs, gbuffer, LightingPush{inputs.constants});
               });
  }

 private:
  uint32_t most_;  // lights
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
