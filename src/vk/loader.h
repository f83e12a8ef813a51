// The Vulkan loader, found at run time: nothing links libvulkan, so that the program can report what is missing.
#pragma once

#include <volk.h>

#include <string>

namespace latelight::vk {

struct Loader {
  std::string library;  // the library opened, or tried
  std::string error;    // dlopen's message; empty: loaded
  bool found() const { return error.empty(); }
};

// Opens libvulkan.so.1, or what LATELIGHT_VULKAN_LOADER names, and loads the global functions. A success is kept for
// the rest of the process. Never throws.
Loader loadVulkan();

}  // namespace latelight::vk
