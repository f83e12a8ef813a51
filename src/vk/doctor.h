// What this machine lacks to render, in plain words.
#pragma once

#include <string>
#include <vector>

#include "vk/device.h"

namespace latelight::vk {

struct Finding {
  bool ok = false;
  std::string sentence;
  std::string remedy;  // what to do, in sentences; empty where ok
};

struct Diagnosis {
  std::vector<Finding> findings;  // in the order things are needed: loader, drivers, devices, choice
  std::vector<DeviceInfo> devices;
  bool usable = false;  // some device can render
};

// Findings about a list of devices: whether each is usable, and which one `auto` chooses.
std::vector<Finding> examineDevices(const std::vector<DeviceInfo>& devices);

// Checks everything, even after something is found missing. Never throws because of a finding.
Diagnosis diagnose();

}  // namespace latelight::vk
