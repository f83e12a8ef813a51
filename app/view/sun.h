// The option sun in a form for editing.
#pragma once

#include <string>

namespace latelight::app {

struct Sun {
  float azimuth = 30, elevation = 40, lux = 3.14159f;  // degrees
};
Sun sunOf(const std::string& option);  // missing values keep the defaults above
std::string textOf(const Sun& sun);

}  // namespace latelight::app
