// The devices that a batch works on.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vk/device.h"

namespace latelight::data {

// UUIDs of those that `text` says, by comma: "auto" is the one that `latelight render` takes, "all" every usable one
// that does not run on the CPU (or the CPU device, where there is no other). Numbers and UUIDs in CUDA_VISIBLE_DEVICES
// leave out the others of "auto" and "all": numbers count the devices that do not run on the CPU; "" and "-1" leave out
// all of those. Throws Error(NoDevice).
std::vector<std::string> chooseDevices(const std::vector<vk::DeviceInfo>& devices, const std::string& text,
                                       const std::optional<std::string>& cudaVisible);

}  // namespace latelight::data
