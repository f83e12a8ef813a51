// Shaders convert every half to its float.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "gpu_math/run_shader.h"
#include "test_device.h"
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
  struct {
    VkDeviceAddress results;
    uint32_t count;
  } const push{out.address(), kPairs};
  test::runShader(device, "gpu_math_halves", push, push.count, 1, 64);
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
