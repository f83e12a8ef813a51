// The measurement shaders of `bench lights` and `bench shade`: the shaders for peak rates do the work that is counted,
// and the bound uses every synthetic light.
#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "render/base/pass.h"
#include "render/submit/renderer.h"
#include "scene/light_types.h"
#include "scene/load/load.h"
#include "study/bench_lighting.h"
#include "study/ceilings.h"
#include "study/ceilings_push.h"
#include "study/light_bound.h"
#include "test_device.h"

namespace latelight::study {
namespace {

vk::Device makeDevice() {
  return vk::Device({.selector = test::testDevice(), .validation = true});
}

// --- ceilings -------------------------------------------------------------------------------------------------------

// Runs one pass of a shader that finds its buffers by address; returns the contents of `results`.
template <typename Push>
std::vector<std::byte> runCeiling(vk::Device& device, const char* shader, uint32_t invocations, uint64_t bytes,
                                  const Push& push) {
  graph::Executor executor(device);
  graph::Graph graph(executor);
  const graph::BufferId results =
      graph.create(vk::BufferDesc{.size = bytes, .kind = vk::MemoryKind::Readback, .name = "results"});
  render::addCompute({device, graph},
                     {.stage = graph::Stage::Output,
                      .name = shader,
                      .shader = shader,
                      .bindings = render::Bindings(device),
                      .size = {invocations, 1, 1},
                      .buffers = {{results, graph::Use::StorageWrite}},
                      .groupX = 256,
                      .groupY = 1},
                     [&](graph::Context& context) { return push(context.buffer(results).address()); });
  graph.exports(results, graph::Use::HostRead);
  const graph::Submission& done = executor.run(graph, graph.compile());
  const std::byte* first = done.buffer(results).mapped();
  return {first, first + bytes};
}

TEST(Ceilings, TheCopyCopiesEveryByte) {
  vk::Device device = makeDevice();
  constexpr uint32_t kInvocations = 3 * 256;
  std::vector<std::byte> bytes(sizeof(shared::uvec4) * shared::kCopyChunk * kInvocations);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>((i * 2654435761u) >> 13);
  const vk::Buffer source = vk::uploadedBuffer(device, "source", bytes);
  EXPECT_EQ(runCeiling(device, "copy_ceiling.comp", kInvocations, bytes.size(),
                       [&](VkDeviceAddress target) {
                         return shared::CopyPush{source.address(), target};
                       }),
            bytes);
  EXPECT_TRUE(device.validationMessages().empty());
}

// Compared with the same sums in double precision: every step of every chain affects the result.
TEST(Ceilings, TheArithmeticIsDone) {
  vk::Device device = makeDevice();
  constexpr uint32_t kInvocations = 512, kRounds = 5;
  constexpr float kFactor = 0.99f, kSummand = 0.5f;
  const std::vector<std::byte> bytes = runCeiling(device, "arithmetic_ceiling.comp", kInvocations,
                                                  kInvocations * sizeof(float), [&](VkDeviceAddress results) {
                                                    return shared::ArithmeticPush{results, kFactor, kSummand, kRounds};
                                                  });
  for (uint32_t i = 0; i < kInvocations; ++i) {
    double sum = 0;
    for (uint32_t chain = 0; chain < shared::kArithmeticChains; ++chain) {
      double x = (0.25 * (chain % 4) + i % 256) * (chain < 4 ? 1 : 0.5);
      for (uint32_t step = 0; step < kRounds * shared::kArithmeticSteps; ++step) x = x * kFactor + kSummand;
      sum += x;
    }
    float result;
    std::memcpy(&result, &bytes[i * sizeof(float)], sizeof(float));
    ASSERT_NEAR(result, sum, 1e-4 * sum) << i;
  }
  EXPECT_TRUE(device.validationMessages().empty());
}

// --- the bound ------------------------------------------------------------------------------------------------------

TEST(LightBound, UsesEveryLightOfEveryType) {
  vk::Device device = makeDevice();
  const scene::Scene scene = scene::load("builtin:hall,lights=1");
  render::Renderer renderer(device, scene, nullptr);
  render::Settings settings{.width = 64, .height = 36};
  settings.shadows = render::ShadowFormat::None;
  for (uint32_t type = 0; type < scene::lightTypes().size(); ++type)
    for (uint32_t way = 0; way < render::choices<render::Shading>().size(); ++way)
      for (const uint32_t lights : {0u, 7u}) {
        const render::TechniqueInfo bound = lightBound(type, lights);
        settings.lighting = &bound;
        settings.shading = static_cast<render::Shading>(way);
        const LightCounts counts = countLights(renderer, scene.cameras.front(), {}, settings);
        EXPECT_DOUBLE_EQ(counts.tested, lights) << scene::lightTypes()[type].name;  // the hall fills the picture
        EXPECT_DOUBLE_EQ(counts.used, lights) << scene::lightTypes()[type].name << " " << way;
      }
  EXPECT_TRUE(device.validationMessages().empty());
}

TEST(LightTimes, AreListsAndLightingFrameByFrame) {
  PassSamples passes;
  const auto frame = [&](double lists, double lighting) {
    passes.add(std::vector<graph::PassTime>{{graph::Stage::Visibility, "depth", 100, 5},
                                            {graph::Stage::Lighting, "light lists", lists, 0},
                                            {graph::Stage::Lighting, "lighting tiled", lighting, 9}});
  };
  frame(1, 30);
  frame(2, 10);
  frame(3, 20);
  const LightTimes times = lightTimes(passes);
  EXPECT_EQ(times.lists, 2);
  EXPECT_EQ(times.lighting, 20);
  EXPECT_EQ(times.spread, 100 * (27 - 17.5) / 23);  // between the quartiles of 12, 23 and 31
  EXPECT_EQ(times.trafficBytes, 9u);
}

}  // namespace
}  // namespace latelight::study
