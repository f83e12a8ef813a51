// Lists devices, checks them against the requirements, and resolves device selectors.
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "base/lowercase.h"
#include "base/text.h"
#include "vk/added_drivers.h"
#include "vk/cuda_devices.h"
#include "vk/features.h"
#include "vk/instance.h"

namespace latelight::vk {

namespace {

const char* typeName(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "cpu";
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual";
    default:
      return "other";
  }
}

std::string versionName(uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

std::vector<std::string> findMissing(VkPhysicalDevice device, uint32_t apiVersion) {
  if (apiVersion < VK_API_VERSION_1_3) return {fmt::format("Vulkan 1.3 (it has {})", versionName(apiVersion))};
  Features features;
  vkGetPhysicalDeviceFeatures2(device, &features.core);
  std::vector<std::string> missing = missingFeatures(requiredFeatures(), features);
  if (!findQueueFamily(device, VK_QUEUE_COMPUTE_BIT)) missing.push_back("a queue for compute");
  // The device must support either the graphics pipeline or --raster compute.
  if (!missingFeatures(computeFeatures(), features).empty())
    std::ranges::copy(missingToDraw(device), std::back_inserter(missing));
  VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
  vkGetPhysicalDeviceProperties2(device, &properties);
  if ((subgroup.supportedOperations & kSubgroupOperations) != kSubgroupOperations ||
      !(subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT))
    missing.push_back("ballots, shuffles and reductions in compute subgroups");
  return missing;
}

bool isOwnCpuDriver(const DeviceInfo& info) {
  return info.type == "cpu" &&
         std::ranges::any_of(addedDrivers(), [](const AddedDriver& driver) { return driver.isCpu; });
}

std::string join(const std::vector<std::string>& parts) {
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string listNames(const std::vector<DeviceInfo>& devices) {
  std::vector<std::string> names;
  for (const DeviceInfo& device : devices) names.push_back(fmt::format("{}: {}", device.index, device.name));
  return join(names);
}

DeviceChoice choose(const DeviceInfo& device, std::string why) {
  if (!device.missing.empty())
    fail(ExitCode::NoDevice,
         "The device {} is not usable because it lacks {}: choose another (see `latelight devices`).", device.name,
         join(device.missing));
  return {device, std::move(why)};
}

DeviceChoice chooseAutomatically(const std::vector<DeviceInfo>& devices) {
  for (const char* type : {"discrete", "integrated", "virtual", "cpu", "other"})
    for (const DeviceInfo& device : devices)
      if (device.type == type && device.missing.empty())
        return {device, fmt::format("{} is the first usable device in the order discrete, integrated, virtual, cpu",
                                    device.name)};
  fail(ExitCode::NoDevice, "No device is usable ({} lacks {}): run `latelight doctor`.", devices[0].name,
       join(devices[0].missing));
}

// Returns the device that CUDA numbers so. `selector` is "cuda:N", or "cuda" for "cuda:0".
DeviceChoice chooseByCuda(const std::vector<DeviceInfo>& devices, const std::string& selector) {
  const std::string_view number = std::string_view(selector).substr(std::min<size_t>(selector.size(), 5));
  const std::optional<uint32_t> index = selector == "cuda" ? 0u : parseNumber<uint32_t>(number);
  const std::optional<std::vector<std::string>> uuids = cudaDevices();
  if (!uuids)
    fail(ExitCode::NoDevice,
         "The device {} cannot be found: CUDA's driver (libcuda.so.1) is missing or does not start.",
         shortened(selector));
  if (!index || *index >= uuids->size())
    fail(ExitCode::NoDevice, "CUDA has no device {}: it lists {} (see CUDA_VISIBLE_DEVICES).", shortened(selector),
         uuids->size());
  for (const DeviceInfo& device : devices)
    if (device.uuid == (*uuids)[*index])
      return choose(device, fmt::format("{} is CUDA's device {}", device.name, *index));
  fail(ExitCode::NoDevice, "CUDA's device {} is not among Vulkan's ({}): run `latelight doctor`.", *index,
       listNames(devices));
}

// Returns the device with this number, UUID or name, and the reason; null if there is none.
std::pair<const DeviceInfo*, std::string> find(const std::vector<DeviceInfo>& devices, const std::string& selector) {
  // A number is always an index, even if names contain it.
  const bool digits = selector.find_first_not_of("0123456789") == std::string::npos;
  if (digits && selector.size() < 2 * VK_UUID_SIZE) {
    const std::optional<uint32_t> index = parseNumber<uint32_t>(selector);
    for (const DeviceInfo& device : devices)
      if (device.index == index) return {&device, fmt::format("it is device number {}", selector)};
    return {nullptr, ""};
  }
  std::string uuid = lowercase(selector);
  std::erase(uuid, '-');
  for (const DeviceInfo& device : devices)
    if (device.uuid == uuid) return {&device, "it has that UUID"};
  for (const DeviceInfo& device : devices)
    if (lowercase(device.name).find(lowercase(selector)) != std::string::npos)
      return {&device, fmt::format("it is the first device with \"{}\" in its name", selector)};
  return {nullptr, ""};
}

}  // namespace

std::optional<uint32_t> findQueueFamily(VkPhysicalDevice device, VkQueueFlags kinds) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  std::optional<uint32_t> best;
  for (uint32_t i = 0; i < count; ++i)
    if ((families[i].queueFlags & kinds) == kinds &&
        (!best || std::popcount(families[i].queueFlags) < std::popcount(families[*best].queueFlags)))
      best = i;
  return best;
}

std::vector<std::string> missingToDraw(VkPhysicalDevice device) {
  Features features;
  vkGetPhysicalDeviceFeatures2(device, &features.core);
  std::vector<std::string> missing = missingFeatures(graphicsFeatures(), features);
  if (!findQueueFamily(device, VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT))
    missing.push_back("a queue for graphics and compute");
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(device, &properties);
  constexpr uint32_t kColorAttachments = 8;  // for the layout `exact` and the light target
  if (properties.limits.maxColorAttachments < kColorAttachments)
    missing.push_back(fmt::format("{} color attachments", kColorAttachments));
  return missing;
}

DeviceInfo describe(VkPhysicalDevice device, uint32_t index) {
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceIDProperties id{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES, &driver};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &id};
  vkGetPhysicalDeviceProperties2(device, &properties);
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(device, &memory);

  DeviceInfo info;
  info.index = index;
  info.name = properties.properties.deviceName;
  info.uuid = fmt::format("{:02x}", fmt::join(id.deviceUUID, ""));
  info.type = typeName(properties.properties.deviceType);
  info.driver =
      fmt::format("{} {}{}", driver.driverName, driver.driverInfo, isOwnCpuDriver(info) ? " (latelight-cpu)" : "");
  info.apiVersion = versionName(properties.properties.apiVersion);
  for (uint32_t i = 0; i < memory.memoryHeapCount; ++i)
    if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) info.memory += memory.memoryHeaps[i].size;
  info.missing = findMissing(device, properties.properties.apiVersion);
  return info;
}

std::vector<DeviceInfo> listDevices() {
  Instance instance(false);
  std::vector<DeviceInfo> list;
  for (VkPhysicalDevice device : instance.devices())
    list.push_back(describe(device, static_cast<uint32_t>(list.size())));
  return list;
}

DeviceChoice chooseDevice(const std::vector<DeviceInfo>& devices, const std::string& selector) {
  if (devices.empty())
    fail(ExitCode::NoDevice, "There is no Vulkan device: run `latelight doctor` to find out what is missing.");
  if (selector == "auto") return chooseAutomatically(devices);
  if (selector == "cpu") {
    for (const DeviceInfo& device : devices)
      if (device.type == "cpu")
        return choose(device, fmt::format("{} is the device that runs on the CPU", device.name));
    fail(ExitCode::NoDevice, "No device runs on the CPU (there is {}): install mesa-vulkan-drivers.",
         listNames(devices));
  }
  if (selector == "cuda" || selector.starts_with("cuda:")) return chooseByCuda(devices, selector);
  auto [device, why] = find(devices, selector);
  if (!device)
    fail(ExitCode::NoDevice, "No device is called \"{}\": choose auto, cpu, cuda:0, or one of {}.", shortened(selector),
         listNames(devices));
  return choose(*device, fmt::format("{} was asked for: {}", device->name, why));
}

}  // namespace latelight::vk
