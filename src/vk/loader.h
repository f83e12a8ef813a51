// The Vulkan loader, found at run time: nothing links libvulkan, so the program can say what is missing.
#pragma once

#include <volk.h>

#include <string>

namespace latelight::vk {

struct Loader {
  std::string library;  // what was opened, or tried
  std::string error;    // dlopen's words; empty: loaded
  bool found() const { return error.empty(); }
};

// Opens libvulkan.so.1, or what LATELIGHT_VULKAN_LOADER names, and loads the global functions. Once a process where it
// succeeds. Never throws.
Loader loadVulkan();

}  // namespace latelight::vk
