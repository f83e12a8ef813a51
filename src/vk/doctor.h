// What is missing between this machine and a picture, in plain words.
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

// What can be said of a list of devices: each one's use, and what `auto` chooses.
std::vector<Finding> examineDevices(const std::vector<DeviceInfo>& devices);

// Looks at everything, also where the first thing is missing already. Never throws for what it finds.
Diagnosis diagnose();

}  // namespace latelight::vk
