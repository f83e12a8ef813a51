// Diagnosis for `latelight doctor`: finds and describes what prevents this machine from rendering.
#pragma once

#include <string>
#include <vector>

#include "vk/device.h"

namespace latelight::vk {

struct Finding {
  bool ok = false;
  std::string sentence;
  std::string remedy;  // what to do, in sentences; empty if ok
};

struct Diagnosis {
  std::vector<Finding> findings;  // in the order of dependence: loader, drivers, devices, choice
  std::vector<DeviceInfo> devices;
  bool usable = false;  // at least one device can render
};

// Returns findings about a list of devices: if each one is usable, and which one `auto` selects.
std::vector<Finding> examineDevices(const std::vector<DeviceInfo>& devices);

// Checks everything, even after a check has failed. Never throws because of a finding.
Diagnosis diagnose();

}  // namespace latelight::vk
