// Latelight's device requirements, as data: device creation, `devices` and `doctor` read the same tables.
#pragma once

#include <volk.h>

#include <span>
#include <string>
#include <vector>

namespace latelight::vk {

// Vulkan 1.3's feature structures, chained. Neither copied nor moved: the chain points into it.
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
  const char* name;   // Vulkan's
  const char* words;  // description for users
  VkBool32& (*of)(Features&);
};

std::span<const Feature> requiredFeatures();
// Enabled where the device has them: what the raster hardware takes, what the raster compute takes, and others.
std::span<const Feature> graphicsFeatures();
std::span<const Feature> computeFeatures();
std::span<const Feature> optionalFeatures();

// Those of a list that are off in `offered`: "64-bit integers in shaders (shaderInt64)".
std::vector<std::string> missingFeatures(std::span<const Feature> features, Features& offered);

// What lanes of compute shaders do with each other, and those of fragment shaders where the device can.
inline constexpr VkSubgroupFeatureFlags kSubgroupOperations =
    VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT |
    VK_SUBGROUP_FEATURE_SHUFFLE_BIT;

inline constexpr const char* kOptionalExtensions[] = {
    VK_EXT_MEMORY_BUDGET_EXTENSION_NAME,
    VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME,   // buffers that other APIs read
    VK_EXT_POST_DEPTH_COVERAGE_EXTENSION_NAME,  // transparency, with several samples a pixel
};

}  // namespace latelight::vk
