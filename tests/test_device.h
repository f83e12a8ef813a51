// The device that tests run on.
#pragma once

#include <cstdlib>
#include <string>

namespace latelight::test {

// The device that LATELIGHT_TEST_DEVICE selects (vk/device.h); a CPU device by default.
inline std::string testDevice() {
  const char* name = std::getenv("LATELIGHT_TEST_DEVICE");
  return name && *name ? name : "cpu";
}

}  // namespace latelight::test
