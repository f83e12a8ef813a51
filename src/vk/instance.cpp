#include "vk/instance.h"

#include <string_view>

#include "base/error.h"
#include "vk/loader.h"
#include "vk/system_limits.h"

namespace latelight::vk {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

[[noreturn]] void failInstance(VkResult result) {
  if (result == VK_ERROR_LAYER_NOT_PRESENT)
    fail(ExitCode::NoDevice,
         "The validation layer {} is not installed: install Debian's vulkan-validationlayers, or run without "
         "validation.",
         kValidationLayer);
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    fail(ExitCode::NoDevice,
         "The Vulkan loader finds no usable driver: run `latelight doctor` to find out what is missing.");
  fail(ExitCode::NoDevice, "Vulkan does not start (vkCreateInstance returns {}): run `latelight doctor`.",
       static_cast<int>(result));
}

}  // namespace

Instance::Instance(bool validation) {
  if (const auto limit = limitOnDrivers()) fail(limit->code, "{}: {}.", limit->sentence, limit->remedy);
  const Loader loader = loadVulkan();
  if (!loader.found())
    fail(ExitCode::NoDevice, "There is no Vulkan loader ({}): install libvulkan1, and run `latelight doctor`.",
         loader.error);
  debugUtils_ = true;
  VkResult result = create(validation, true);
  // Querying the loader's extensions first would load every driver twice.
  if (result == VK_ERROR_EXTENSION_NOT_PRESENT && !validation) {
    debugUtils_ = false;
    result = create(validation, false);
  }
  if (result != VK_SUCCESS) failInstance(result);
  loadFunctions(instance_);
}

VkResult Instance::create(bool validation, bool debugUtils) {
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "latelight";
  application.apiVersion = VK_API_VERSION_1_3;

  VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messenger.pfnUserCallback = hear;
  messenger.pUserData = this;
  const VkValidationFeatureEnableEXT checks[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = checks;

  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, validation ? &features : nullptr};
  info.pApplicationInfo = &application;
  info.enabledExtensionCount = debugUtils ? 1 : 0;
  info.ppEnabledExtensionNames = &extension;
  info.enabledLayerCount = validation ? 1 : 0;
  info.ppEnabledLayerNames = &kValidationLayer;
  const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
  if (result != VK_SUCCESS || !validation) return result;

  auto createMessenger = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  return createMessenger(instance_, &messenger, nullptr, &messenger_);
}

Instance::~Instance() {
  if (messenger_) {
    auto destroyMessenger = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroyMessenger(instance_, messenger_, nullptr);
  }
  auto destroy = reinterpret_cast<PFN_vkDestroyInstance>(vkGetInstanceProcAddr(instance_, "vkDestroyInstance"));
  destroy(instance_, nullptr);
}

VkBool32 Instance::hear(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                        const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  // Shaders have optional outputs, such as counts of lights. Vulkan discards those without an attachment.
  const std::string_view id = data->pMessageIdName ? data->pMessageIdName : "";
  if (id.starts_with("Undefined-Value-ShaderOutputNotConsumed")) return VK_FALSE;
  auto* self = static_cast<Instance*>(user);
  std::lock_guard lock(self->mutex_);
  self->messages_.emplace_back(data->pMessage);
  return VK_FALSE;
}

std::vector<VkPhysicalDevice> Instance::devices() const {
  uint32_t count = 0;
  VkResult result = vkEnumeratePhysicalDevices(instance_, &count, nullptr);
  // Drivers without hardware return VK_ERROR_INITIALIZATION_FAILED, which counts as having no device.
  if (result != VK_SUCCESS) return {};
  std::vector<VkPhysicalDevice> devices(count);
  result = vkEnumeratePhysicalDevices(instance_, &count, devices.data());
  if (result != VK_SUCCESS && result != VK_INCOMPLETE) return {};
  devices.resize(count);
  return devices;
}

std::vector<std::string> Instance::takeMessages() {
  std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

}  // namespace latelight::vk
