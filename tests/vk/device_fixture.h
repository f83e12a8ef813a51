// A device under validation, shared by the tests of a process; any message fails the test that caused it. test_device.h
// selects the device.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "vk/commands.h"
#include "vk/device.h"
#include "vk/resources.h"

namespace latelight::vk {

class DeviceTest : public testing::Test {
 protected:
  static Device& device();
  void SetUp() override { device().validationMessages(); }
  void TearDown() override {
    for (const std::string& message : device().validationMessages()) ADD_FAILURE() << message;
  }
};

// Bytes that differ from their neighbors and from row to row.
inline std::vector<std::byte> pattern(size_t size, uint32_t seed = 1) {
  std::vector<std::byte> bytes(size);
  uint32_t state = seed * 2654435761u + 1;
  for (std::byte& byte : bytes) byte = static_cast<std::byte>((state = state * 1664525u + 1013904223u) >> 24);
  return bytes;
}

// Makes the device's writes so far visible to the host.
inline void recordHostBarrier(VkCommandBuffer commands) {
  recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                      VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

// Returns all bytes of a buffer, in any kind of memory.
std::vector<std::byte> readBack(Device& device, const Buffer& buffer);
// Returns all mip levels of layer 0 of an image in READ_ONLY_OPTIMAL, in the format that Uploader accepts.
std::vector<std::byte> readBack(Device& device, const Image& image);

}  // namespace latelight::vk
