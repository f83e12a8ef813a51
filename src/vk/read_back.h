// Reads device memory on the host, for callers that may wait.
#pragma once

#include <cstddef>
#include <span>

#include "vk/device.h"
#include "vk/resources.h"

namespace latelight::vk {

// Copies the bytes of a buffer from an offset on, after everything that was submitted, and waits.
void readBack(Device& device, const Buffer& from, VkDeviceSize offset, std::span<std::byte> to);

}  // namespace latelight::vk
