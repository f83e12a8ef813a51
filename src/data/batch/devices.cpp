#include "data/batch/devices.h"

#include <algorithm>

#include "base/error.h"
#include "base/lowercase.h"
#include "base/text.h"

namespace latelight::data {

namespace {

// Returns the 32 hexadecimal digits of "GPU-xxxxxxxx-xxxx-...", or fewer if the UUID is abbreviated.
std::string digitsOf(std::string_view uuid) {
  if (uuid.starts_with("GPU-")) uuid.remove_prefix(4);
  std::string digits;
  for (const char c : uuid)
    if (c != '-') digits += lowercase(c);
  return digits;
}

// Reads CUDA_VISIBLE_DEVICES as CUDA does, where CUDA cannot be asked: the first entry that matches no device ends the
// list.
std::vector<vk::DeviceInfo> visibleTo(const std::vector<vk::DeviceInfo>& gpus, const std::string& list) {
  std::vector<vk::DeviceInfo> visible;
  for (const std::string_view entry : splitAtCommas(list)) {
    const std::optional<size_t> number = parseNumber<size_t>(entry);
    const std::string digits = digitsOf(entry);
    const auto matches = [&](const vk::DeviceInfo& gpu) {
      return number ? &gpu - gpus.data() == static_cast<ptrdiff_t>(*number)
                    : entry.starts_with("GPU-") && !digits.empty() && gpu.uuid.starts_with(digits);
    };
    const auto found = std::ranges::find_if(gpus, matches);
    if (found == gpus.end()) break;
    visible.push_back(*found);
  }
  return visible;
}

std::vector<vk::DeviceInfo> withUuids(const std::vector<vk::DeviceInfo>& gpus, const std::vector<std::string>& uuids) {
  std::vector<vk::DeviceInfo> listed;
  for (const std::string& uuid : uuids)
    std::ranges::copy_if(gpus, std::back_inserter(listed), [&](const auto& gpu) { return gpu.uuid == uuid; });
  return listed;
}

// Returns the devices that "auto" and "all" choose from.
std::vector<vk::DeviceInfo> candidates(const std::vector<vk::DeviceInfo>& devices,
                                       const std::optional<std::string>& cudaVisible,
                                       const std::optional<std::vector<std::string>>& cudaUuids) {
  std::vector<vk::DeviceInfo> gpus, usable;
  std::ranges::copy_if(devices, std::back_inserter(gpus), [](const auto& device) { return device.type != "cpu"; });
  if (cudaVisible && !gpus.empty()) {
    gpus = cudaUuids ? withUuids(gpus, *cudaUuids) : visibleTo(gpus, *cudaVisible);
    if (gpus.empty() && !cudaVisible->empty() && *cudaVisible != "-1")
      fail(ExitCode::NoDevice, "CUDA_VISIBLE_DEVICES is \"{}\", which matches no device: use --devices",
           shortened(*cudaVisible));
  }
  std::ranges::copy_if(gpus, std::back_inserter(usable), [](const auto& device) { return device.missing.empty(); });
  if (usable.empty())
    std::ranges::copy_if(devices, std::back_inserter(usable), [](const auto& device) { return device.type == "cpu"; });
  return usable;
}

}  // namespace

std::vector<std::string> chooseDevices(const std::vector<vk::DeviceInfo>& devices, const std::string& text,
                                       const std::optional<std::string>& cudaVisible,
                                       const std::optional<std::vector<std::string>>& cudaUuids) {
  if (text == "auto") return {vk::chooseDevice(candidates(devices, cudaVisible, cudaUuids), "auto").device.uuid};
  std::vector<std::string> uuids;
  if (text == "all")
    for (const vk::DeviceInfo& device : candidates(devices, cudaVisible, cudaUuids)) uuids.push_back(device.uuid);
  else
    for (const std::string_view selector : splitAtCommas(text))
      uuids.push_back(vk::chooseDevice(devices, std::string(selector)).device.uuid);
  if (uuids.empty()) fail(ExitCode::NoDevice, "no device is usable: run `latelight doctor`");
  return uuids;
}

}  // namespace latelight::data
