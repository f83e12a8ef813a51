// The drivers that Latelight adds to those that the Vulkan loader finds by itself: NVIDIA's where a container has its
// libraries but no manifest that works, and the CPU driver of the package latelight-cpu or of the archive.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace latelight::vk {

struct AddedDriver {
  std::filesystem::path manifest;  // the driver file (.json) that the loader is told to read
  std::string why;                 // a sentence
  bool isCpu = false;
};

// Chooses the drivers to add, writes their manifests, and names them in VK_ADD_DRIVER_FILES, which the loader reads for
// each instance. Adds nothing if VK_DRIVER_FILES or VK_ICD_FILENAMES lists the drivers already. Where a CPU driver is
// added, the system's lavapipe is disabled (VK_LOADER_DRIVERS_DISABLE): one process cannot use two versions of LLVM
// safely. Changes the environment, so it runs once, before the first instance; loadVulkan() calls it.
void addDrivers();

// Returns the drivers that addDrivers() has added.
const std::vector<AddedDriver>& addedDrivers();

}  // namespace latelight::vk
