// Chooses the devices that a batch renders on.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vk/device.h"

namespace latelight::data {

// Returns the UUIDs of the devices that `text`, a comma-separated list, selects. "auto" is the device that `latelight
// render` uses. "all" is every usable device that does not run on the CPU, or the CPU device if there is no other.
// `cudaVisible`, the value of CUDA_VISIBLE_DEVICES, restricts "auto" and "all" to the devices that it lists by number
// or UUID; "" and "-1" exclude all that do not run on the CPU. `cudaUuids` are the devices that CUDA then lists
// (vk::cudaDevices()), in its order. Without CUDA's driver, numbers count the devices that do not run on the CPU.
// Throws Error(NoDevice).
std::vector<std::string> chooseDevices(const std::vector<vk::DeviceInfo>& devices, const std::string& text,
                                       const std::optional<std::string>& cudaVisible,
                                       const std::optional<std::vector<std::string>>& cudaUuids = std::nullopt);

}  // namespace latelight::data
