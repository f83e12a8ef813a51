// Shaders convert every half to its float.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "gpu_math/spirv.h"
#include "test_device.h"
#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::shared {
namespace {

// IEEE 754 binary16.
float floatOfHalf(uint32_t half) {
  const uint32_t exponent = half >> 10 & 0x1f, fraction = half & 0x3ff;
  float magnitude = std::ldexp(static_cast<float>(fraction), -24);
  if (exponent == 0x1f)
    magnitude = fraction ? NAN : INFINITY;
  else if (exponent > 0)
    magnitude = std::ldexp(static_cast<float>(0x400 + fraction), static_cast<int>(exponent) - 25);
  return half & 0x8000 ? -magnitude : magnitude;
}

TEST(Halves, AreConvertedToTheirFloats) {
  constexpr uint32_t kPairs = 1u << 15;
  vk::Device device({.selector = test::testDevice(), .validation = true});
  vk::Buffer out(device, {.size = kPairs * 2 * sizeof(float), .kind = vk::MemoryKind::Readback, .name = "floats"});
  const vk::Pipeline pipeline =
      vk::makePipeline(device, vk::ComputeDesc{.name = "halves", .code = test::readSpirv("gpu_math_halves")});
  struct {
    VkDeviceAddress results;
    uint32_t count;
  } const push{out.address(), kPairs};
  vk::DescriptorPool pool(device);
  device.submitAndWait([&](VkCommandBuffer buffer) {
    vk::Commands commands(device, buffer, pool);
    commands.bind(pipeline, std::initializer_list<vk::BoundImage>{}, push);
    commands.dispatch(push.count, 1, 1, 64, 1);
    vk::recordMemoryBarrier(buffer, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                            VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  });
  EXPECT_TRUE(device.validationMessages().empty());
  for (uint32_t half = 0; half < 2 * kPairs; ++half) {
    const float found = out.as<float>()[half], expected = floatOfHalf(half);
    if (std::isnan(expected))
      EXPECT_TRUE(std::isnan(found)) << half;
    else
      EXPECT_EQ(std::bit_cast<uint32_t>(found), std::bit_cast<uint32_t>(expected)) << half;
  }
}

}  // namespace
}  // namespace latelight::shared
