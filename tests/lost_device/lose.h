// The environment of a program that loses its device at a submission, counted from 1 (layer.cpp).
#pragma once

#include <cstdlib>
#include <map>
#include <string>

#include "without_validation.h"

namespace latelight {

inline std::map<std::string, std::string> losingDevice(int submission) {
  return {{"VK_LAYER_PATH", LATELIGHT_LOST_DEVICE},
          {"VK_INSTANCE_LAYERS", "VK_LAYER_LATELIGHT_lose_device"},
          {"LATELIGHT_LOSE_SUBMISSION", std::to_string(submission)}};
}

// The environment of a program of which one Vulkan call fails without memory.
inline std::map<std::string, std::string> failingCall(const std::string& name, int number) {
  return {{"VK_LAYER_PATH", LATELIGHT_LOST_DEVICE},
          {"VK_INSTANCE_LAYERS", "VK_LAYER_LATELIGHT_lose_device"},
          {"LATELIGHT_FAIL_CALL", name + " " + std::to_string(number)}};
}

// While this object exists, devices that this process creates can lose themselves, one at a time. They have no
// validation layer, because the path of the layer that loses them replaces its path.
class DevicesToLose {
 public:
  DevicesToLose() {
    for (const auto& [name, value] : variables_) setenv(name.c_str(), value.c_str(), 1);
    unsetenv(kSubmission);
  }
  ~DevicesToLose() {
    for (const auto& [name, value] : variables_) unsetenv(name.c_str());
  }
  DevicesToLose(const DevicesToLose&) = delete;
  DevicesToLose& operator=(const DevicesToLose&) = delete;

  // Counted from now on, over all devices.
  void loseAt(int submission) { setenv(kSubmission, std::to_string(submission).c_str(), 1); }
  bool hasLost() const { return !std::getenv(kSubmission); }

 private:
  static constexpr const char* kSubmission = "LATELIGHT_LOSE_SUBMISSION";
  const std::map<std::string, std::string> variables_ = losingDevice(1);
  const test::WithoutValidation withoutValidation_;
};

}  // namespace latelight
