#include "scene/aperture.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/text.h"

namespace latelight::scene {

Aperture parseAperture(std::string_view option, std::string_view text) {
  if (text == "pinhole") return {};
  const bool isNumber = text.starts_with("f/");
  const std::optional<double> value = parseNumber<double>(isNumber ? text.substr(2) : text);
  if (!value || !(*value > 0) || *value > (isNumber ? 1e6 : 100))
    badUsage("{} takes pinhole, an f-number as in f/2.8, or a radius in meters above 0 and up to 100, not \"{}\"",
             option, text);
  return isNumber ? Aperture{.fNumber = *value} : Aperture{.radius = *value};
}

std::string apertureText(const Aperture& aperture) {
  if (aperture.isPinhole()) return "pinhole";
  return aperture.fNumber > 0 ? fmt::format("f/{}", aperture.fNumber) : fmt::format("{}", aperture.radius);
}

}  // namespace latelight::scene
