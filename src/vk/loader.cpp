#define VOLK_IMPLEMENTATION
#include "vk/loader.h"

#include <dlfcn.h>

#include <cstdlib>
#include <mutex>
#include <optional>
#include <utility>

#include "base/fork.h"
#include "vk/added_drivers.h"

namespace latelight::vk {

namespace {

Loader open(const std::string& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) return {library, dlerror()};
  auto entry = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(handle, "vkGetInstanceProcAddr"));
  if (!entry) {
    dlclose(handle);
    return {library, library + " is not a Vulkan loader: it has no vkGetInstanceProcAddr"};
  }
  volkInitializeCustom(entry);
  return {library, ""};
}

}  // namespace

Loader loadVulkan() {
  static ForkSafeMutex mutex;
  static std::optional<Loader> loaded;
  std::lock_guard lock(mutex);
  if (loaded) return *loaded;
  const char* chosen = std::getenv("LATELIGHT_VULKAN_LOADER");
  Loader loader = open(chosen && *chosen ? chosen : "libvulkan.so.1");
  if (!loader.found()) return loader;
  addDrivers();
  loaded = loader;
  return loader;
}

void loadFunctions(VkInstance instance) {
  static ForkSafeMutex mutex;
  static bool loaded = false;
  std::lock_guard lock(mutex);
  if (!std::exchange(loaded, true)) volkLoadInstance(instance);
}

}  // namespace latelight::vk
