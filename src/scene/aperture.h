// The aperture of a thin lens, which blurs what is out of focus.
#pragma once

#include <string>
#include <string_view>

namespace latelight::scene {

// Either an f-number (focal length / diameter) or a radius is above 0; a pinhole has neither.
struct Aperture {
  double fNumber = 0;
  double radius = 0;  // meters
  bool isPinhole() const { return fNumber == 0 && radius == 0; }
  bool operator==(const Aperture&) const = default;
};

// Parses "pinhole", "f/2.8" or a radius in meters, at most 100 m. Throws Error(Usage), with `option` first in the
// message, for invalid text.
Aperture parseAperture(std::string_view option, std::string_view text);
std::string apertureText(const Aperture& aperture);  // the inverse

}  // namespace latelight::scene
