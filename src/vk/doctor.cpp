#include "vk/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "base/error.h"
#include "vk/drivers.h"
#include "vk/loader.h"

namespace latelight::vk {

namespace {

namespace fs = std::filesystem;

constexpr const char* kInstallDriver =
    "For the CPU: apt-get install mesa-vulkan-drivers. For a GPU: install its vendor's driver with the Vulkan part "
    "(NVIDIA: libnvidia-gl of the same version; in a container start it with NVIDIA_DRIVER_CAPABILITIES=all).";

// The folder in which NVIDIA's container tools and some clusters install the driver. No loader searches it.
constexpr const char* kNvidiaFolder = "/usr/local/nvidia/share/vulkan/icd.d";

bool exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

std::string installDriver() {
  std::string remedy = kInstallDriver;
  if (exists(kNvidiaFolder))
    remedy +=
        fmt::format(" Or set VK_DRIVER_FILES to the .json file in {}, where NVIDIA's driver lies.", kNvidiaFolder);
  return remedy;
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

void examineDrivers(std::vector<Finding>& findings) {
  const DriverFiles drivers = findDriverFiles();
  if (drivers.files.empty())
    findings.push_back(
        {false, fmt::format("No Vulkan driver is installed: there is no driver file (.json) in {}.", drivers.where),
         installDriver()});
  for (const fs::path& file : drivers.files) {
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

// A kernel driver without the Vulkan driver is common in containers on compute clusters.
void examineNvidia(Diagnosis& diagnosis) {
  const bool listed = std::any_of(diagnosis.devices.begin(), diagnosis.devices.end(), [](const DeviceInfo& device) {
    return device.name.find("NVIDIA") != std::string::npos;
  });
  if (listed || !exists("/proc/driver/nvidia/version")) return;
  diagnosis.findings.push_back({false, "There is an NVIDIA GPU, but no Vulkan device of it.", installDriver()});
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
  return {false, fmt::format("{}, can't be used: it lacks {}.", what, fmt::join(device.missing, ", ")),
          "Update its driver, or choose another device with --device."};
}

Finding examineChoice(const std::vector<DeviceInfo>& devices) {
  if (std::any_of(devices.begin(), devices.end(), isUsable)) {
    const DeviceChoice choice = chooseDevice(devices, "auto");
    return {true, fmt::format("`--device auto` chooses device {}: {}.", choice.device.index, choice.why), ""};
  }
  const bool anyVersion = std::any_of(devices.begin(), devices.end(), hasVersion);
  return {false, anyVersion ? "No device has all that is needed of Vulkan 1.3." : "No device has Vulkan 1.3 or newer.",
          installDriver()};
}

void examineLoaded(Diagnosis& diagnosis) {
  try {
    diagnosis.devices = listDevices();
  } catch (const Error& error) {
    // Error messages end with the advice to run this command.
    const std::string sentence = error.what();
    diagnosis.findings.push_back(
        {false, sentence.substr(0, sentence.find(": run `latelight doctor`")) + ".", installDriver()});
    return;
  }
  diagnosis.usable = std::any_of(diagnosis.devices.begin(), diagnosis.devices.end(), isUsable);
  for (Finding& finding : examineDevices(diagnosis.devices)) diagnosis.findings.push_back(std::move(finding));
}

}  // namespace

std::vector<Finding> examineDevices(const std::vector<DeviceInfo>& devices) {
  if (devices.empty())
    return {{false, "No driver finds a device.",
             "Look whether this user may open /dev/dri/render* (groups render and video) or, for NVIDIA, whether "
             "`nvidia-smi` lists the GPU. " +
                 installDriver()}};
  std::vector<Finding> findings;
  for (const DeviceInfo& device : devices) findings.push_back(examineDevice(device));
  findings.push_back(examineChoice(devices));
  return findings;
}

Diagnosis diagnose() {
  Diagnosis diagnosis;
  const Finding loader = examineLoader();
  diagnosis.findings.push_back(loader);
  examineDrivers(diagnosis.findings);
  if (loader.ok) examineLoaded(diagnosis);
  examineNvidia(diagnosis);
  return diagnosis;
}

}  // namespace latelight::vk
