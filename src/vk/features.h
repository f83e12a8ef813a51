// The device features that Latelight requires, as tables that device creation, `devices` and `doctor` share.
#pragma once

#include <volk.h>

#include <span>
#include <string>
#include <vector>

namespace latelight::vk {

// Vulkan 1.3's feature structures, chained. It can be neither copied nor moved: the chain points into it.
struct Features {
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  VkPhysicalDeviceVulkan11Features v11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES};
  VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  Features();
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

struct Feature {
  const char* name;   // name in the Vulkan specification
  const char* words;  // description for users
  VkBool32& (*of)(Features&);
};

std::span<const Feature> requiredFeatures();
// Features that are enabled if the device supports them: those that --raster hardware requires, those that --raster
// compute requires, and others.
std::span<const Feature> graphicsFeatures();
std::span<const Feature> computeFeatures();
std::span<const Feature> optionalFeatures();

// Returns the features of a list that are off in `offered`, such as "64-bit integers in shaders (shaderInt64)".
std::vector<std::string> missingFeatures(std::span<const Feature> features, Features& offered);

// The subgroup operations that compute shaders use, and fragment shaders where the device supports them.
inline constexpr VkSubgroupFeatureFlags kSubgroupOperations =
    VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT |
    VK_SUBGROUP_FEATURE_SHUFFLE_BIT;

inline constexpr const char* kOptionalExtensions[] = {
    VK_EXT_MEMORY_BUDGET_EXTENSION_NAME,
    VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME,   // the texel window of CPU devices
    VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME,     // buffers that other APIs import
    VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME,  // semaphores that other APIs signal
    VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME,    // transparency with several samples per pixel
};

}  // namespace latelight::vk
