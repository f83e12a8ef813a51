// Opens the Vulkan loader at run time. Nothing links libvulkan, so that the program can report what is missing.
#pragma once

#include <volk.h>

#include <string>

namespace latelight::vk {

struct Loader {
  std::string library;  // the library that was opened or tried
  std::string error;    // dlopen's message; empty: loaded
  bool found() const { return error.empty(); }
};

// Opens libvulkan.so.1, or the library that LATELIGHT_VULKAN_LOADER names, and loads the global functions. The library
// stays open for the rest of the process. Never throws.
Loader loadVulkan();

// Loads the functions that take an instance or a device. The loader's are the same for all instances, and find the
// driver by their first argument. Calls after the first do nothing, because other threads may be calling them.
void loadFunctions(VkInstance instance);

}  // namespace latelight::vk
