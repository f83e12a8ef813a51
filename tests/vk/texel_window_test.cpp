// The texel window of CPU devices: what lies in it, and what happens when it is full.
#include "vk/texel_window.h"

#include "vk/device_fixture.h"
#include "vk/memory.h"

namespace latelight::vk {
namespace {

class TexelWindowTest : public DeviceTest {
 protected:
  void SetUp() override {
    DeviceTest::SetUp();
    if (!device().memory().window()) GTEST_SKIP() << device().info().name << " has no texel window";
  }
  static bool isInWindow(const Buffer& buffer) {
    return buffer.address() / TexelWindow::kSize == device().memory().window()->address() / TexelWindow::kSize;
  }
};

TEST_F(TexelWindowTest, HoldsWhatShadersLoad) {
  for (const VkDeviceSize size : {1u, 100u, 4096u, 40u << 20}) {
    const Buffer buffer(device(), {.size = size});
    EXPECT_TRUE(isInWindow(buffer)) << size;
    EXPECT_EQ(buffer.address() % 16, 0u) << size;
    EXPECT_EQ(reinterpret_cast<uintptr_t>(buffer.mapped()), buffer.address()) << size;
  }
  EXPECT_TRUE(isInWindow(Buffer(device(), {.size = 100, .kind = MemoryKind::Upload})));
  EXPECT_FALSE(isInWindow(Buffer(device(), {.size = 100, .kind = MemoryKind::Readback})));
  EXPECT_FALSE(isInWindow(Buffer(device(), {.size = 100, .exported = true})));
  EXPECT_TRUE(device().memory().isAllInWindow());
}

// Lanes without an address load zeros from the start of the window.
TEST_F(TexelWindowTest, StartsWithZeros) {
  const VkDeviceAddress address = device().memory().window()->address();
  ASSERT_EQ(address % TexelWindow::kSize, 0u);
  const auto* start = reinterpret_cast<const std::byte*>(address);
  EXPECT_EQ(std::vector<std::byte>(start, start + 4096), std::vector<std::byte>(4096));
}

TEST_F(TexelWindowTest, LargeBuffersReturnTheirMemory) {
  const uint64_t before = device().memory().statistics().usedBytes;
  const VkDeviceSize size = 8u << 20;
  VkDeviceAddress address = 0;
  {
    const Buffer buffer(device(), {.size = size});
    address = buffer.address();
    std::memset(buffer.mapped(), 1, size);
    EXPECT_EQ(device().memory().statistics().usedBytes, before + size);
  }
  EXPECT_EQ(device().memory().statistics().usedBytes, before);
  const Buffer again(device(), {.size = size});
  ASSERT_EQ(again.address(), address);
  EXPECT_EQ(again.mapped()[size / 2], std::byte{0}) << "the system's pages are new";
}

TEST_F(TexelWindowTest, OtherMemoryFollowsWhenItIsFull) {
  {
    std::vector<Buffer> all;
    for (VkDeviceSize size = TexelWindow::kSize / 2; device().memory().isAllInWindow(); size /= 2)
      all.emplace_back(device(), BufferDesc{.size = size, .name = "filler"});
    EXPECT_FALSE(isInWindow(all.back()));
    EXPECT_NE(all.back().address(), 0u);
    std::memset(all.back().mapped(), 1, all.back().size());
  }
  EXPECT_TRUE(device().memory().isAllInWindow());
}

}  // namespace
}  // namespace latelight::vk
