#include "vk/doctor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "base/error.h"
#include "vk/added_drivers.h"
#include "vk/drivers.h"
#include "vk/loader.h"
#include "vk/system_limits.h"

namespace latelight::vk {

namespace {

namespace fs = std::filesystem;

const std::string kInstallDriver =
    "For the CPU: apt-get install mesa-vulkan-drivers, or pip install latelight-cpu. For a GPU: install its vendor's "
    "driver with the Vulkan part (NVIDIA: libnvidia-gl of the same version; in a container start it with "
    "NVIDIA_DRIVER_CAPABILITIES=all).";

bool exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

Finding examineLoader() {
  const Loader loader = loadVulkan();
  if (loader.found()) return {true, fmt::format("The Vulkan loader {} loads.", loader.library), ""};
  return {false, fmt::format("There is no Vulkan loader: {} does not load ({}).", loader.library, loader.error),
          std::getenv("LATELIGHT_VULKAN_LOADER")
              ? "Unset LATELIGHT_VULKAN_LOADER, or let it name a libvulkan.so.1."
              : "Install it: apt-get install libvulkan1 (vulkan-loader elsewhere), or use the archive that "
                "`./dev bundle` makes, which has one."};
}

// True for driver files in whose place Latelight has added another: the system's lavapipe, since loading both would mix
// two versions of LLVM, and a file of NVIDIA's that leads to no driver that works.
bool isReplaced(const fs::path& file) {
  const auto added = [](bool cpu) {
    return std::ranges::any_of(addedDrivers(), [&](const AddedDriver& driver) { return driver.isCpu == cpu; });
  };
  if (file.filename().string().starts_with("lvp_icd")) return added(true);
  return added(false) && readDriverFile(file).isNvidia() && !probeDriver(file).error.empty();
}

void examineDrivers(std::vector<Finding>& findings) {
  const DriverFiles drivers = findDriverFiles();
  if (drivers.files.empty())
    findings.push_back(
        {false, fmt::format("No Vulkan driver is installed: there is no driver file (.json) in {}.", drivers.where),
         kInstallDriver});
  for (const AddedDriver& driver : addedDrivers()) findings.push_back({true, driver.why, ""});
  for (const fs::path& file : drivers.files) {
    if (isReplaced(file)) continue;
    const DriverProbe probe = probeDriver(file);
    if (probe.error.empty())
      findings.push_back({true, fmt::format("The driver {} ({}) loads.", probe.library, file.string()), ""});
    else
      findings.push_back({false, fmt::format("The driver file {} {}.", file.string(), probe.error),
                          probe.library.empty()
                              ? "Correct it or remove it, or name another in VK_DRIVER_FILES."
                              : "Install the driver's package again with all it needs, or remove the file."});
  }
}

// A kernel driver without a Vulkan driver that works is common in containers. The cases are those of
// github.com/NVIDIA/nvidia-container-toolkit, issues 16, 191 and 1952.
void examineNvidia(Diagnosis& diagnosis) {
  const bool listed = std::any_of(diagnosis.devices.begin(), diagnosis.devices.end(), [](const DeviceInfo& device) {
    return device.name.find("NVIDIA") != std::string::npos;
  });
  if (listed) return;
  std::vector<NvidiaLibrary> libraries = probeNvidiaLibraries();
  std::erase_if(libraries, [](const NvidiaLibrary& library) { return library.isMissing; });
  if (libraries.empty()) {
    if (exists("/proc/driver/nvidia/version"))
      diagnosis.findings.push_back(
          {false, "There is an NVIDIA GPU, but its driver's Vulkan libraries (libGLX_nvidia.so.0) are not here.",
           "In a container: start it with NVIDIA_DRIVER_CAPABILITIES=all (or with \"graphics\" in the list), and with "
           "--runtime=nvidia --gpus all. Elsewhere: install libnvidia-gl of the driver's version."});
    return;
  }
  for (const NvidiaLibrary& library : libraries)
    if (!library.error.empty())
      diagnosis.findings.push_back(
          {false, fmt::format("NVIDIA's driver library {} {}.", library.library, library.error),
           "Install what it needs: apt-get install libxext6 libegl1. In a container, start it with "
           "NVIDIA_DRIVER_CAPABILITIES=all, so that all libraries of the driver are mounted."});
  if (libraries.back().error.empty() && exists("/proc/driver/nvidia/version"))
    diagnosis.findings.push_back(
        {false, "NVIDIA's Vulkan driver loads, but finds no device.",
         "Look whether `nvidia-smi` lists the GPU, whether this user may open /dev/nvidia*, and whether the libraries "
         "have the version of the kernel's driver (/proc/driver/nvidia/version)."});
}

bool isUsable(const DeviceInfo& device) {
  return device.missing.empty();
}

bool hasVersion(const DeviceInfo& device) {
  unsigned major = 0, minor = 0;
  std::sscanf(device.apiVersion.c_str(), "%u.%u", &major, &minor);
  return major > 1 || (major == 1 && minor >= 3);
}

Finding examineDevice(const DeviceInfo& device) {
  const std::string what = fmt::format("Device {}, {} ({}, Vulkan {}, driver {})", device.index, device.name,
                                       device.type, device.apiVersion, device.driver);
  if (isUsable(device)) return {true, what + ", can be used.", ""};
  return {false, fmt::format("{}, cannot be used: it lacks {}.", what, fmt::join(device.missing, ", ")),
          "Update its driver, or choose another device with --device."};
}

Finding examineChoice(const std::vector<DeviceInfo>& devices) {
  if (std::any_of(devices.begin(), devices.end(), isUsable)) {
    const DeviceChoice choice = chooseDevice(devices, "auto");
    return {true, fmt::format("`--device auto` chooses device {}: {}.", choice.device.index, choice.why), ""};
  }
  const bool anyVersion = std::any_of(devices.begin(), devices.end(), hasVersion);
  return {false, anyVersion ? "No device has all that is needed of Vulkan 1.3." : "No device has Vulkan 1.3 or newer.",
          kInstallDriver};
}

Finding findingOf(const SystemLimit& limit) {
  std::string remedy = limit.remedy + ".";
  remedy[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(remedy[0])));
  return {false, limit.sentence + ".", remedy};
}

void examineLoaded(Diagnosis& diagnosis) {
  try {
    diagnosis.devices = listDevices();
  } catch (const Error& error) {
    // Error messages end with the advice to run this command.
    const std::string sentence = error.what();
    diagnosis.findings.push_back(
        {false, sentence.substr(0, sentence.find(": run `latelight doctor`")) + ".", kInstallDriver});
    return;
  }
  const auto hasUsable = [&](bool cpu) {
    return std::ranges::any_of(diagnosis.devices, [cpu](const DeviceInfo& device) {
      return isUsable(device) && (device.type == "cpu") == cpu;
    });
  };
  diagnosis.usable = hasUsable(false);
  for (Finding& finding : examineDevices(diagnosis.devices)) diagnosis.findings.push_back(std::move(finding));
  if (!hasUsable(true)) return;
  if (const auto limit = limitOnCpuThreads())
    diagnosis.findings.push_back(findingOf(*limit));
  else
    diagnosis.usable = true;
}

}  // namespace

std::vector<Finding> examineDevices(const std::vector<DeviceInfo>& devices) {
  if (devices.empty())
    return {{false, "No driver finds a device.",
             "Look whether this user may open /dev/dri/render* (groups render and video) or, for NVIDIA, whether "
             "`nvidia-smi` lists the GPU. " +
                 kInstallDriver}};
  std::vector<Finding> findings;
  for (const DeviceInfo& device : devices) findings.push_back(examineDevice(device));
  findings.push_back(examineChoice(devices));
  return findings;
}

Diagnosis diagnose() {
  Diagnosis diagnosis;
  // Under these limits, the loader and the drivers would seem to be missing or broken.
  if (const auto limit = limitOnDrivers()) {
    diagnosis.findings.push_back(findingOf(*limit));
    return diagnosis;
  }
  const Finding loader = examineLoader();
  diagnosis.findings.push_back(loader);
  examineDrivers(diagnosis.findings);
  if (loader.ok) examineLoaded(diagnosis);
  examineNvidia(diagnosis);
  return diagnosis;
}

}  // namespace latelight::vk
