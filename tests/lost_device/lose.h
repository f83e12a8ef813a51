// The environment of a program that loses its device at a submission, counted from 1 (layer.cpp).
#pragma once

#include <map>
#include <string>

namespace latelight {

inline std::map<std::string, std::string> losingDevice(int submission) {
  return {{"VK_LAYER_PATH", LATELIGHT_LOST_DEVICE},
          {"VK_INSTANCE_LAYERS", "VK_LAYER_LATELIGHT_lose_device"},
          {"LATELIGHT_LOSE_SUBMISSION", std::to_string(submission)}};
}

}  // namespace latelight
