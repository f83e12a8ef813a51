// The functions that cmake/loads.cmake generates.
#include <gtest/gtest.h>

#include <bit>
#include <iterator>

#include "gpu_math/run_shader.h"
#include "shared/random.h"
#include "struct_headers.h"
#include "test_device.h"
#include "vk/resources.h"

namespace latelight::shared {
namespace {

struct Load {
  const char* name;
  size_t bytes;
};
constexpr Load kLoads[] = {
#define LOAD(type) {#type, sizeof(type)},
#include "loads.inc"
#undef LOAD
};

TEST(Loads, LoadWhatTheCompilerLoads) {
  constexpr uint kBytes = 4096;
  vk::Device device({.selector = test::testDevice(), .validation = true});
  vk::Buffer structs(device, {.size = kBytes, .kind = vk::MemoryKind::Upload, .name = "structs"});
  vk::Buffer results(device,
                     {.size = std::size(kLoads) * sizeof(uint), .kind = vk::MemoryKind::Readback, .name = "results"});
  Random random(1);
  for (uint i = 0; i < kBytes / sizeof(uint); ++i)  // no word is a NaN, which differs from itself
    structs.as<uint>()[i] = std::bit_cast<uint>(random.logUniform(1e-3f, 1e3f));
  struct {
    VkDeviceAddress structs, results;
  } const push{structs.address(), results.address()};
  test::runShader(device, "gpu_math_loads", push, 1, 1, 1);
  for (size_t i = 0; i < std::size(kLoads); ++i) {
    EXPECT_LE(kLoads[i].bytes, kBytes) << kLoads[i].name;
    EXPECT_EQ(results.as<uint>()[i], 1u) << kLoads[i].name;
  }
  EXPECT_TRUE(device.validationMessages().empty());
}

// Arrays of these structs are loaded, and loads of 16 bytes have to be aligned.
TEST(Loads, AreOfStructsWhoseArraysAreAligned) {
  for (const char* name : {"Instance", "Light", "Material", "RayNode", "View"}) {
    const auto load = std::ranges::find(kLoads, std::string(name), &Load::name);
    ASSERT_NE(load, std::end(kLoads)) << name;
    EXPECT_EQ(load->bytes % 16, 0u) << name;
  }
}

}  // namespace
}  // namespace latelight::shared
