// The option sun, as it is edited.
#pragma once

#include <string>

namespace latelight::app {

struct Sun {
  float azimuth = 30, elevation = 40, lux = 3.14159f;  // degrees
};
Sun sunOf(const std::string& option);  // what it does not say is as it is here
std::string textOf(const Sun& sun);

}  // namespace latelight::app
