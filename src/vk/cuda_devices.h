// CUDA's numbering of GPUs, so that `--device cuda:0` is the GPU that torch.device("cuda:0") is. Vulkan has an order of
// its own.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace latelight::vk {

// Returns the UUIDs (32 hexadecimal digits) of the GPUs that CUDA lists, by their numbers, or nothing if CUDA's driver
// is not installed or does not start. CUDA itself applies CUDA_VISIBLE_DEVICES and CUDA_DEVICE_ORDER.
std::optional<std::vector<std::string>> cudaDevices();

}  // namespace latelight::vk
