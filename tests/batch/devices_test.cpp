// The devices that a batch selects on simulated machines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "data/batch/devices.h"

namespace latelight::data {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const std::string kFirst = "00000000000000000000000000000aaa", kSecond = "00000000000000000000000000000bbb",
                  kCpu = "00000000000000000000000000000ccc";

std::vector<vk::DeviceInfo> machine(bool gpus) {
  std::vector<vk::DeviceInfo> devices{{.index = 0, .name = "llvmpipe", .uuid = kCpu, .type = "cpu"}};
  if (!gpus) return devices;
  devices.push_back({.index = 1, .name = "Big one", .uuid = kFirst, .type = "discrete"});
  devices.push_back({.index = 2, .name = "Big two", .uuid = kSecond, .type = "discrete"});
  return devices;
}

std::vector<std::string> chosen(bool gpus, const std::string& text,
                                const std::optional<std::string>& visible = {}) try {
  return chooseDevices(machine(gpus), text, visible);
} catch (const Error& error) {
  EXPECT_EQ(error.code(), ExitCode::NoDevice);
  return {};
}

TEST(Devices, TheCpuOnlyWhereAskedForOrNothingElseIsThere) {
  EXPECT_THAT(chosen(true, "auto"), ElementsAre(kFirst));
  EXPECT_THAT(chosen(true, "all"), ElementsAre(kFirst, kSecond));
  EXPECT_THAT(chosen(true, "cpu"), ElementsAre(kCpu));
  EXPECT_THAT(chosen(false, "auto"), ElementsAre(kCpu));
  EXPECT_THAT(chosen(false, "all"), ElementsAre(kCpu));
}

TEST(Devices, ByNumberNameAndUuid) {
  EXPECT_THAT(chosen(true, "2,1"), ElementsAre(kSecond, kFirst));
  EXPECT_THAT(chosen(true, kSecond), ElementsAre(kSecond));
  EXPECT_THAT(chosen(true, "two"), ElementsAre(kSecond));
  EXPECT_THAT(chosen(true, "3"), IsEmpty());
  EXPECT_THAT(chosen(false, "two"), IsEmpty());
}

// CUDA's order is not always Vulkan's (CUDA_DEVICE_ORDER).
TEST(Devices, CudaCanBeAsked) {
  const auto chosenBy = [](const std::string& text, const std::vector<std::string>& cuda) {
    return chooseDevices(machine(true), text, "0,1", cuda);
  };
  EXPECT_THAT(chosenBy("all", {kSecond, kFirst}), ElementsAre(kSecond, kFirst));
  EXPECT_THAT(chosenBy("auto", {kSecond, kFirst}), ElementsAre(kSecond));
  EXPECT_THAT(chosenBy("all", {kSecond}), ElementsAre(kSecond));
  EXPECT_THROW(chosenBy("all", {std::string(32, 'f')}), Error);
}

TEST(Devices, CudasVariableLeavesOthersOut) {
  EXPECT_THAT(chosen(true, "all", "1"), ElementsAre(kSecond));
  EXPECT_THAT(chosen(true, "auto", "1"), ElementsAre(kSecond));
  EXPECT_THAT(chosen(true, "all", "1,0"), ElementsAre(kSecond, kFirst));
  EXPECT_THAT(chosen(true, "all", "GPU-00000000-0000-0000-0000-000000000bbb"), ElementsAre(kSecond));
  EXPECT_THAT(chosen(true, "all", "0,7,1"), ElementsAre(kFirst)) << "as CUDA has it, a wrong one ends the list";
  EXPECT_THAT(chosen(true, "all", ""), ElementsAre(kCpu)) << "none is visible";
  EXPECT_THAT(chosen(true, "all", "MIG-1c0f"), IsEmpty()) << "not the CPU in its place";
  EXPECT_THAT(chosen(false, "all", "0"), ElementsAre(kCpu)) << "there is nothing to leave out";
  EXPECT_THAT(chosen(true, "1", "1"), ElementsAre(kFirst)) << "what is named is meant";
}

}  // namespace
}  // namespace latelight::data
