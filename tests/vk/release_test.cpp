// Releasing resources allocates nothing, because destructors release them after memory ran out.
#include <gtest/gtest.h>

#include <memory>
#include <new>
#include <optional>
#include <vector>

#include "base/json_tree.h"
#include "base/keep.h"
#include "counted_allocations.h"
#include "test_device.h"
#include "vk/commands.h"
#include "vk/gate.h"
#include "vk/memory.h"
#include "vk/resources.h"
#include "without_validation.h"

namespace latelight::vk {
namespace {

using test::allocationsOf;

TEST(Release, TheCounterCounts) {
  EXPECT_EQ(allocationsOf([] { std::vector<int>(3).swap(*std::make_unique<std::vector<int>>()); }), 2);
}

struct Resources {
  explicit Resources(Device& device)
      : heap(device, device.memory().typeFor(needs(device), MemoryKind::Device), 1 << 16, 1 << 16),
        placed(device, {.size = 256}, heap, 0),
        buffer(device, {.size = 256}),
        image(device, {.format = VK_FORMAT_R8G8B8A8_UNORM,
                       .width = 8,
                       .height = 8,
                       .layers = 3,
                       .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT}),
        sampler(makeSampler(device, {})),
        descriptors(device) {
    const Binding binding = Binding::Sampled;
    const BoundImage bound{image.arrayView(), sampler.get()};
    descriptors.make(device.cache().setLayout({binding}), {&binding, 1}, {&bound, 1});
  }
  static VkMemoryRequirements needs(Device& device) { return memoryRequirements(device, BufferDesc{.size = 256}); }

  Heap heap;
  Buffer placed, buffer;
  Image image;
  Handle<VkSampler> sampler;
  DescriptorPool descriptors;
};

// Once while the device may still use the resources, and once when their destruction was due.
TEST(Release, AllocatesNothing) {
  const test::WithoutValidation layers;
  Device device({.selector = test::testDevice()});
  Gate gate(device);
  gate.close();
  std::optional<Resources> used(device), others(device);
  const uint64_t submission = device.submit([](VkCommandBuffer) {});
  EXPECT_EQ(allocationsOf([&] { used.reset(); }), 0);
  gate.open();
  const int byWait = allocationsOf([&] { device.wait(submission); });
  const int atOnce = allocationsOf([&] { others.reset(); });
  if (!device.isCpu()) GTEST_SKIP() << "the drivers of GPUs may allocate";
  EXPECT_EQ(byWait, 0);
  EXPECT_EQ(atOnce, 0);
}

// A buffer that is created while each of its allocations fails in turn is destroyed: its memory is free again.
TEST(Release, FailedCreationsLeaveNothing) {
  const test::WithoutValidation layers;
  Device device({.selector = test::testDevice()});
  const auto create = [&] { const Buffer buffer(device, {.size = 100'000'000, .name = "a buffer of a hundred MB"}); };
  const auto fails = [&](int number) {
    try {
      allocationsOf(create, number);
      return false;
    } catch (const std::bad_alloc&) {
      return true;
    }
  };
  int number = 1;
  for (; fails(number); ++number) EXPECT_EQ(device.memory().statistics().allocations, 0u) << number;
  EXPECT_GT(number, 4);
  EXPECT_EQ(device.memory().statistics().allocations, 0u);
}

TEST(Release, RangesOfABlockAllocateNothing) {
  BlockRanges ranges(4096);
  std::vector<uint64_t> offsets;
  for (int i = 0; i < 32; ++i) offsets.push_back(ranges.allocate(64, 32));
  EXPECT_EQ(allocationsOf([&] {
              for (size_t i = 0; i < offsets.size(); i += 2) ranges.release(offsets[i]);
              for (size_t i = 1; i < offsets.size(); i += 2) ranges.release(offsets[i]);
            }),
            0);
  EXPECT_EQ(ranges.largestFree(), 4096u);
}

// A range is taken from the middle of a free one, or from its end.
TEST(Release, FailedAllocationsLeaveABlockAsItWas) {
  BlockRanges ranges(4096);
  const uint64_t first = ranges.allocate(100, 1);
  for (const uint64_t size : {64, 3968}) {
    EXPECT_THROW(allocationsOf([&] { ranges.allocate(size, 128); }, 1), std::bad_alloc);
    EXPECT_EQ(ranges.freeBytes(), 3996u);
    EXPECT_EQ(ranges.largestFree(), 3996u);
  }
  ranges.release(first);
  EXPECT_EQ(ranges.largestFree(), 4096u);
}

TEST(Release, JsonTreesAllocateNothing) {
  constexpr const char* kText =
      R"({"a": [[1, 2, {"b": "a string that is longer than the value itself"}], []], "c": {}})";
  std::optional<JsonTree> tree(nlohmann::json::parse(kText));
  std::optional<nlohmann::json> plain(**tree);
  EXPECT_EQ(*plain, nlohmann::json::parse(kText));
  EXPECT_EQ(allocationsOf([&] { tree.reset(); }), 0);
  EXPECT_GT(allocationsOf([&] { plain.reset(); }), 0) << "JsonTree is not needed";
}

TEST(Release, WhatCannotBeKeptIsDestroyed) {
  std::vector<std::unique_ptr<std::shared_ptr<int>>> list;
  const auto watched = std::make_shared<int>(1);
  auto object = std::make_unique<std::shared_ptr<int>>(watched);
  EXPECT_EQ(allocationsOf([&] { keepForReuse(list, std::move(object)); }, 1), 1);
  EXPECT_TRUE(list.empty());
  EXPECT_EQ(watched.use_count(), 1);
  keepForReuse(list, std::make_unique<std::shared_ptr<int>>(watched));
  EXPECT_EQ(list.size(), 1u);
  EXPECT_EQ(watched.use_count(), 2);
}

}  // namespace
}  // namespace latelight::vk
