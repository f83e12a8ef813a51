#include "app/view/sun.h"

#include <fmt/format.h>

#include <vector>

#include "base/text.h"

namespace latelight::app {

Sun sunOf(const std::string& option) {
  const std::vector<float> given = parseNumbers(option);
  Sun sun;
  if (given.size() >= 2) sun.azimuth = given[0], sun.elevation = given[1];
  if (given.size() >= 3) sun.lux = given[2];
  return sun;
}

std::string textOf(const Sun& sun) {
  return fmt::format("{:.4g},{:.4g},{:.4g}", sun.azimuth, sun.elevation, sun.lux);
}

}  // namespace latelight::app
