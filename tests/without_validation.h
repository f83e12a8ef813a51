// Devices without the validation layer, for tests that measure memory, because the layer keeps everything that it has
// seen, and for tests that lose devices.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace latelight::test {

// While this object exists, new devices ignore LATELIGHT_VALIDATION, which `./dev test validation` sets.
class WithoutValidation {
 public:
  WithoutValidation() {
    if (const char* value = std::getenv(kName)) before_ = value;
    unsetenv(kName);
  }
  ~WithoutValidation() {
    if (before_) setenv(kName, before_->c_str(), 1);
  }
  WithoutValidation(const WithoutValidation&) = delete;
  WithoutValidation& operator=(const WithoutValidation&) = delete;

 private:
  static constexpr const char* kName = "LATELIGHT_VALIDATION";
  std::optional<std::string> before_;
};

}  // namespace latelight::test
