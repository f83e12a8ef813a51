// Doubles that shaders round to floats are those of the host, even if the compiler merges conversions.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "gpu_math/run_shader.h"
#include "shared/random.h"
#include "test_device.h"
#include "vk/resources.h"

namespace latelight::shared {
namespace {

struct Rounded {
  double rounded, widened, remainder;
};

// Numbers of all signs and of 60 binary orders of magnitude, one in four next to or halfway between two floats, and
// those that have no remainder.
std::vector<double> someNumbers(size_t count) {
  std::vector<double> numbers{0.0, -0.0, 1.0, -3.5, 0x1p24 + 1, 0x1p24 + 3, -0x1p24 - 1, 0x1.fffffffp3, INFINITY};
  Random random(3);
  while (numbers.size() < count) {
    const uint64_t mantissa = uint64_t{random.bits()} << 20 ^ random.bits();
    const double x = std::ldexp(1 + double(mantissa & 0xfffffffffffff) * 0x1p-52, int(random.bits() % 60) - 30);
    numbers.push_back(random.uniform() < 0.5f ? x : -x);
    constexpr uint64_t kHalf = 1ull << 28;  // of the last bit of a float
    const uint64_t bits = std::bit_cast<uint64_t>(x) & ~(2 * kHalf - 1);
    for (const uint64_t part : {kHalf - 1, kHalf, kHalf + 1})
      if (random.uniform() < 0.1f) numbers.push_back(std::bit_cast<double>(bits | part));
  }
  numbers.resize(count);
  return numbers;
}

std::vector<Rounded> roundOnDevice(const std::vector<double>& numbers) {
  vk::Device device({.selector = test::testDevice(), .validation = true});
  vk::Buffer in(device, {.size = numbers.size() * sizeof(double), .kind = vk::MemoryKind::Upload, .name = "numbers"});
  vk::Buffer out(device,
                 {.size = numbers.size() * sizeof(Rounded), .kind = vk::MemoryKind::Readback, .name = "results"});
  std::ranges::copy(numbers, in.as<double>());
  struct {
    VkDeviceAddress numbers, results;
    uint count;
  } const push{in.address(), out.address(), static_cast<uint>(numbers.size())};
  test::runShader(device, "gpu_math_float_rounding", push, push.count, 1, 64);
  EXPECT_TRUE(device.validationMessages().empty());
  return {out.as<Rounded>(), out.as<Rounded>() + numbers.size()};
}

TEST(FloatRounding, IsThatOfTheHost) {
  const std::vector<double> numbers = someNumbers(4096);
  const std::vector<Rounded> found = roundOnDevice(numbers);
  size_t rounded = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    const auto expected = double{static_cast<float>(numbers[i])};
    EXPECT_EQ(found[i].rounded, expected) << numbers[i];
    EXPECT_EQ(found[i].widened, expected) << numbers[i];
    rounded += expected != numbers[i];
    if (!std::isfinite(numbers[i])) continue;
    EXPECT_EQ(static_cast<float>(found[i].remainder), static_cast<float>(numbers[i] - expected)) << numbers[i];
  }
  EXPECT_GT(rounded, numbers.size() / 2);
}

}  // namespace
}  // namespace latelight::shared
