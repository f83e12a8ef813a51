// Devices: submissions, deferred deletion, memory, exported buffers, caches, and the selection of a device.
#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <future>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "test_device.h"
#include "vk/device_fixture.h"
#include "vk/features.h"
#include "vk/gate.h"
#include "vk/instance.h"

namespace latelight::vk {
namespace {

using testing::AnyOf;
using testing::HasSubstr;

ExitCode codeOf(const std::function<void()>& call, std::string* sentence = nullptr) {
  try {
    call();
  } catch (const Error& error) {
    if (sentence) *sentence = error.what();
    return error.code();
  }
  return ExitCode::Done;
}

// Threads call Vulkan's functions by pointers that all instances share: a later instance must not write them.
TEST(InstanceTest, LaterOnesLeaveTheFunctions) {
  const Instance first(false);
  const PFN_vkDestroyFence loaded =
      std::exchange(vkDestroyFence, [](VkDevice, VkFence, const VkAllocationCallbacks*) {});
  const PFN_vkDestroyFence marked = vkDestroyFence;
  const Instance second(false);
  EXPECT_EQ(std::exchange(vkDestroyFence, loaded), marked);
}

TEST_F(DeviceTest, IsUsable) {
  EXPECT_EQ(device().info().type == "cpu", device().isCpu());
  EXPECT_TRUE(device().isCpu() || test::testDevice() != "cpu");
  EXPECT_TRUE(device().info().missing.empty());
  EXPECT_EQ(device().info().uuid.size(), 32u);
  EXPECT_FALSE(device().has("VK_EXT_no_such_extension"));
}

// Two writes of the same bytes without a barrier between them. Without the validation layer, this test fails.
TEST_F(DeviceTest, APlantedHazardIsReported) {
  const Buffer buffer(device(), {.size = 4096, .name = "hazard"});
  device().submitAndWait([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, buffer.get(), 0, 2048, 1);
    vkCmdFillBuffer(commands, buffer.get(), 1024, 2048, 2);
  });
  const std::vector<std::string> messages = device().validationMessages();
  ASSERT_FALSE(messages.empty());
  EXPECT_THAT(messages.front(), testing::ContainsRegex("WRITE.AFTER.WRITE"));
  EXPECT_THAT(messages.front(), HasSubstr("hazard")) << "objects are named";
}

TEST_F(DeviceTest, DeletesAtOnceIfIdleAndElseAfterTheSubmission) {
  int dead = 0;
  device().deferDeletion(makeDeletion([&] { ++dead; }));
  EXPECT_EQ(dead, 1);
  device().submitAndWait([&](VkCommandBuffer) {
    device().deferDeletion(makeDeletion([&] { ++dead; }));
    EXPECT_EQ(dead, 1);
  });
  EXPECT_EQ(dead, 2);
}

TEST_F(DeviceTest, SubmitsWithoutWaitingAndFinishesInOrder) {
  const Buffer target(device(), {.size = 64, .kind = MemoryKind::Readback});
  Gate gate(device());
  gate.close();
  const uint64_t first = device().submit([](VkCommandBuffer) {});
  const uint64_t second = device().submit([&](VkCommandBuffer commands) {
    vkCmdFillBuffer(commands, target.get(), 0, VK_WHOLE_SIZE, 7);
    recordHostBarrier(commands);
  });
  EXPECT_EQ(second, first + 1);
  EXPECT_FALSE(device().finished(first));
  EXPECT_FALSE(device().finished(second));
  gate.open();
  device().wait(second);
  EXPECT_TRUE(device().finished(first));
  EXPECT_TRUE(device().finished(second));
  EXPECT_EQ(target.as<uint32_t>()[15], 7u);
}

TEST_F(DeviceTest, DeletesWhenEarlierSubmissionsHaveFinished) {
  Gate gate(device());
  gate.close();
  int dead = 0;
  const uint64_t first =
      device().submit([&](VkCommandBuffer) { device().deferDeletion(makeDeletion([&] { ++dead; })); });
  device().deferDeletion(makeDeletion([&] { ++dead; }));
  EXPECT_EQ(dead, 0);
  gate.open();
  device().wait(first);
  EXPECT_EQ(dead, 2);
}

// Objects that are deleted in a submission that failed may still be used by earlier submissions.
TEST_F(DeviceTest, ASubmissionThatThrowsDeletesAfterThoseBeforeIt) {
  Gate gate(device());
  gate.close();
  int dead = 0;
  const uint64_t before = device().submit([](VkCommandBuffer) {});
  const auto record = [&](VkCommandBuffer) {
    device().deferDeletion(makeDeletion([&] { ++dead; }));
    throw std::runtime_error("no");
  };
  EXPECT_THROW(device().submit(record), std::runtime_error);
  EXPECT_EQ(dead, 0);
  gate.open();
  device().wait(before);
  EXPECT_EQ(dead, 1);
}

TEST_F(DeviceTest, ManySubmissionsNeedNoWait) {
  const Buffer counter(device(), {.size = 64, .kind = MemoryKind::Readback});
  uint64_t last = 0;
  for (uint32_t i = 0; i < 40; ++i) {
    last = device().submit([&](VkCommandBuffer commands) {
      recordHostBarrier(commands);
      const Buffer brief(device(), {.size = 64});
      vkCmdFillBuffer(commands, brief.get(), 0, VK_WHOLE_SIZE, i);
      vkCmdFillBuffer(commands, counter.get(), 4 * (i % 16), 4, i);
      recordHostBarrier(commands);
    });
  }
  device().wait(last);
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(counter.as<uint32_t>()[i], i < 8 ? 32 + i : 16 + i);
}

TEST(DeviceEnd, RunsPendingDeletions) {
  int dead = 0;
  {
    Device device({.selector = test::testDevice(), .validation = true});
    device.submit([&](VkCommandBuffer) {
      device.deferDeletion(makeDeletion([&] { device.deferDeletion(makeDeletion([&] { ++dead; })); }));
      const Buffer brief(device, {.size = 64});
    });
  }
  EXPECT_EQ(dead, 1);
}

TEST_F(DeviceTest, AResourceDroppedWhileRecordingLivesUntilTheWorkIsDone) {
  const Buffer target(device(), {.size = 64, .kind = MemoryKind::Readback});
  device().submitAndWait([&](VkCommandBuffer commands) {
    const Buffer brief(device(), {.size = 64, .kind = MemoryKind::Upload});
    std::memset(brief.mapped(), 0x5a, 64);
    const VkBufferCopy region{0, 0, 64};
    vkCmdCopyBuffer(commands, brief.get(), target.get(), 1, &region);
    recordHostBarrier(commands);
  });
  EXPECT_EQ(readBack(device(), target), std::vector<std::byte>(64, std::byte{0x5a}));
}

TEST_F(DeviceTest, AnExceptionWhileRecordingLeavesTheDeviceUsable) {
  int dead = 0;
  const auto record = [&](VkCommandBuffer) {
    device().deferDeletion(makeDeletion([&] { ++dead; }));
    throw std::runtime_error("no");
  };
  EXPECT_THROW(device().submitAndWait(record), std::runtime_error);
  EXPECT_EQ(dead, 1);
  device().submitAndWait([](VkCommandBuffer) {});
}

TEST_F(DeviceTest, SubmitsFromManyThreads) {
  std::vector<Buffer> buffers;
  for (int i = 0; i < 8; ++i) buffers.emplace_back(device(), BufferDesc{.size = 256, .kind = MemoryKind::Readback});
  std::vector<std::future<void>> tasks;
  for (uint32_t i = 0; i < 8; ++i)
    tasks.push_back(std::async(std::launch::async, [&, i] {
      device().submitAndWait([&](VkCommandBuffer commands) {
        vkCmdFillBuffer(commands, buffers[i].get(), 0, VK_WHOLE_SIZE, i);
        recordHostBarrier(commands);
      });
    }));
  for (auto& task : tasks) task.get();
  for (uint32_t i = 0; i < 8; ++i) EXPECT_EQ(buffers[i].as<uint32_t>()[63], i);
}

TEST_F(DeviceTest, ErrorsCarryTheirCode) {
  std::string sentence;
  EXPECT_EQ(codeOf([] { check(VK_ERROR_DEVICE_LOST, "call", "/a/b.cpp", 3); }), ExitCode::DeviceLost);
  EXPECT_EQ(codeOf([] { check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "call", "/a/b.cpp", 3); }), ExitCode::OutOfMemory);
  EXPECT_EQ(codeOf([] { check(VK_ERROR_FORMAT_NOT_SUPPORTED, "vkCall(x)", "/a/b.cpp", 3); }, &sentence),
            ExitCode::Internal);
  EXPECT_EQ(sentence, "vkCall(x) returns VK_ERROR_FORMAT_NOT_SUPPORTED (b.cpp:3)");
}

TEST_F(DeviceTest, InsufficientMemoryIsAnErrorWithTheSizes) {
  std::string sentence;
  const VkMemoryRequirements needs{VkDeviceSize{1} << 44, 256, ~0u};
  EXPECT_EQ(codeOf([&] { device().memory().allocate(needs, MemoryKind::Device, true, Allocator::Sharing::Blocks); },
                   &sentence),
            ExitCode::OutOfMemory);
  EXPECT_THAT(sentence, AnyOf(HasSubstr("16777216 MiB"), HasSubstr("16777216.0 MiB"))) << "by which limit it meets";
  EXPECT_EQ(codeOf([&] { Buffer(device(), {.size = VkDeviceSize{1} << 40}); }), ExitCode::OutOfMemory);
  EXPECT_EQ(codeOf([&] { Image(device(), {.format = VK_FORMAT_R8_UNORM, .width = 1u << 20}); }), ExitCode::Usage);
}

// Another buffer that imports the memory into the same device contains the bytes written to the first buffer.
TEST_F(DeviceTest, ExportedMemoryIsThatOfTheBuffer) {
  if (!exportsBuffers(device())) GTEST_SKIP() << device().info().name << " exports no buffers";
  const Buffer exported(device(), {.size = 4096, .name = "exported", .exported = true});
  VkExternalMemoryBufferCreateInfo external{VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO};
  external.handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, &external};
  create.size = 4096;
  create.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  VkBuffer again = VK_NULL_HANDLE;
  ASSERT_EQ(vkCreateBuffer(device().get(), &create, nullptr, &again), VK_SUCCESS);
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device().get(), exported.get(), &needs);
  VkImportMemoryFdInfoKHR import{VK_STRUCTURE_TYPE_IMPORT_MEMORY_FD_INFO_KHR};
  import.handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  import.fd = exported.exportMemory();
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &import};
  allocate.allocationSize = exported.memorySize();
  allocate.memoryTypeIndex = device().memory().typeFor(needs, MemoryKind::Device);
  VkDeviceMemory memory = VK_NULL_HANDLE;
  ASSERT_EQ(vkAllocateMemory(device().get(), &allocate, nullptr, &memory), VK_SUCCESS);
  ASSERT_EQ(vkBindBufferMemory(device().get(), again, memory, 0), VK_SUCCESS);

  const Buffer host(device(), {.size = 4096, .kind = MemoryKind::Readback});
  device().submitAndWait(
      [&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, exported.get(), 0, VK_WHOLE_SIZE, 0x12345678u); });
  device().submitAndWait([&](VkCommandBuffer commands) {
    const VkBufferCopy all{0, 0, 4096};
    vkCmdCopyBuffer(commands, again, host.get(), 1, &all);
  });
  for (size_t i = 0; i < 1024; ++i) EXPECT_EQ(host.as<uint32_t>()[i], 0x12345678u);
  vkDestroyBuffer(device().get(), again, nullptr);
  vkFreeMemory(device().get(), memory, nullptr);
}

TEST_F(DeviceTest, MemoryIsAllocatedInBlocksAndReturned) {
  const Allocator::Statistics before = device().memory().statistics();
  {
    std::vector<Buffer> buffers;
    for (int i = 0; i < 100; ++i)
      buffers.emplace_back(device(), BufferDesc{.size = 1000u + i, .kind = MemoryKind::Readback});
    const Allocator::Statistics during = device().memory().statistics();
    EXPECT_LE(during.blocks, before.blocks + 1);
    EXPECT_EQ(during.allocations, before.allocations + 100);
    const Buffer large(device(), {.size = Allocator::kBlockSize, .kind = MemoryKind::Readback});
    EXPECT_EQ(device().memory().statistics().blocks, during.blocks + 1) << "large ones have their own";
    const Image target(device(), {VK_FORMAT_R8_UNORM, 4, 4, 1, 1, 1, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, "target"});
    EXPECT_EQ(device().memory().statistics().blocks, during.blocks + 2) << "render targets too";
  }
  const Allocator::Statistics after = device().memory().statistics();
  EXPECT_EQ(after.allocations, before.allocations);
  EXPECT_EQ(after.usedBytes, before.usedBytes);
  EXPECT_LE(after.blocks, before.blocks + 1) << "one spare block may stay";
}

TEST_F(DeviceTest, DeviceMemoryIsMappedOnTheCpu) {
  if (!device().isCpu()) GTEST_SKIP() << device().info().name << " has memory of its own";
  const Buffer buffer(device(), {.size = 100});
  EXPECT_NE(buffer.mapped(), nullptr);
  EXPECT_NE(buffer.address(), 0u);
}

// A temporary cache folder for one test.
class CacheFolder {
 public:
  CacheFolder() : path_(std::filesystem::path(testing::TempDir()) / fmt::format("latelight-cache-{}", getpid())) {
    if (const char* before = std::getenv("XDG_CACHE_HOME")) before_ = before;
    setenv("XDG_CACHE_HOME", path_.c_str(), 1);
  }
  ~CacheFolder() {
    before_ ? setenv("XDG_CACHE_HOME", before_->c_str(), 1) : unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(path_);
  }

 private:
  std::filesystem::path path_;
  std::optional<std::string> before_;
};

TEST(DeviceStart, ACorruptPipelineCacheIsIgnored) {
  const CacheFolder folder;
  const DeviceOptions options{.selector = test::testDevice(), .validation = true};
  std::string name;
  {
    Device device(options);
    name = fmt::format("pipelines-{}-{:08x}", device.info().uuid, device.properties().driverVersion);
  }
  storeCache(name, pattern(777));
  Device device(options);
  EXPECT_TRUE(device.validationMessages().empty());
  EXPECT_EQ(loadCache(name), pattern(777)) << "the test's own folder was read";
}

TEST(DeviceStart, TwoDevicesLiveAtOnce) {
  Device plain({.selector = test::testDevice(), .validation = false}),
      validated({.selector = test::testDevice(), .validation = true});
  for (Device* device : {&plain, &validated}) {
    const Buffer buffer(*device, {.size = 64, .kind = MemoryKind::Readback, .name = "shared name"});
    device->submitAndWait([&](VkCommandBuffer commands) {
      vkCmdFillBuffer(commands, buffer.get(), 0, VK_WHOLE_SIZE, 7);
      recordHostBarrier(commands);
    });
    EXPECT_EQ(buffer.as<uint32_t>()[15], 7u);
    EXPECT_TRUE(device->validationMessages().empty());
  }
}

DeviceInfo fake(uint32_t index, const char* name, const char* type, std::vector<std::string> missing = {}) {
  DeviceInfo info;
  info.index = index;
  info.name = name;
  info.type = type;
  info.uuid = fmt::format("{:032x}", 0xabc0 + index);
  info.missing = std::move(missing);
  return info;
}

class ChooseDevice : public testing::Test {
 protected:
  uint32_t chosen(const std::string& selector) { return chooseDevice(list, selector).device.index; }
  std::string errorFor(const std::string& selector) {
    std::string sentence;
    EXPECT_EQ(codeOf([&] { chosen(selector); }, &sentence), ExitCode::NoDevice) << selector;
    return sentence;
  }
  std::vector<DeviceInfo> list{fake(0, "llvmpipe", "cpu"), fake(1, "Iris", "integrated"),
                               fake(2, "Old Card", "discrete", {"Vulkan 1.3 (it has 1.2.0)"}),
                               fake(3, "GeForce RTX 3060", "discrete"), fake(4, "Other RTX 3060", "discrete")};
};

TEST_F(ChooseDevice, AutomaticChoosesTheFirstUsableOfTheBestType) {
  EXPECT_EQ(chosen("auto"), 3u);
  list.resize(3);
  EXPECT_EQ(chosen("auto"), 1u);
  list.resize(1);
  EXPECT_EQ(chosen("auto"), 0u);
  list[0].missing = {"scalarBlockLayout"};
  EXPECT_THAT(errorFor("auto"), HasSubstr("scalarBlockLayout"));
  list.clear();
  EXPECT_THAT(errorFor("auto"), HasSubstr("latelight doctor"));
}

TEST_F(ChooseDevice, ByTypeNumberNameAndUuid) {
  EXPECT_EQ(chosen("cpu"), 0u);
  EXPECT_EQ(chosen("1"), 1u);
  EXPECT_EQ(chosen("x 3060"), 3u);
  EXPECT_EQ(chosen("other rtx"), 4u);
  EXPECT_EQ(chosen("0000000000000000000000000000ABC1"), 1u);
  EXPECT_EQ(chosen("00000000-0000-0000-0000-00000000abc4"), 4u);
}

TEST_F(ChooseDevice, ErrorsListTheDevices) {
  EXPECT_THAT(errorFor("2"), HasSubstr("Vulkan 1.3"));
  EXPECT_THAT(errorFor("voodoo"), HasSubstr("1: Iris"));
  EXPECT_THAT(errorFor("99"), HasSubstr("99"));
  EXPECT_THAT(errorFor("3060"), HasSubstr("3060")) << "in names, but a number is an index";
  EXPECT_THAT(errorFor("4294967297"), HasSubstr("4294967297")) << "1, were it cut to 32 bits";
  errorFor("");
  list.erase(list.begin());
  EXPECT_THAT(errorFor("cpu"), HasSubstr("mesa-vulkan-drivers"));
}

TEST(Features, EachRowHasItsOwnField) {
  // A duplicated line would leave one feature unchecked.
  Features features;
  std::vector<const VkBool32*> seen;
  for (auto table : {requiredFeatures(), graphicsFeatures(), computeFeatures(), optionalFeatures()})
    for (const Feature& feature : table) {
      EXPECT_THAT(seen, testing::Not(testing::Contains(&feature.of(features)))) << feature.name;
      seen.push_back(&feature.of(features));
      EXPECT_NE(*feature.words, '\0');
    }
}

}  // namespace
}  // namespace latelight::vk
