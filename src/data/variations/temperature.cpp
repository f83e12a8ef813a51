#include "data/variations/temperature.h"

namespace latelight::data {

glm::dvec3 colorOfTemperature(double kelvin) {
  const double t = 1000 / kelvin;
  const double x = kelvin <= 4000 ? ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
                                  : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390;
  const double y = kelvin <= 2222   ? ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683
                   : kelvin <= 4000 ? ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867
                                    : ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483;
  const glm::dvec3 xyz(x / y, 1, (1 - x - y) / y);
  const glm::dvec3 red(3.2404542, -1.5371385, -0.4985314), green(-0.9692660, 1.8760108, 0.0415560),
      blue(0.0556434, -0.2040259, 1.0572252);
  const glm::dvec3 color = glm::max(glm::dvec3(0), {glm::dot(red, xyz), glm::dot(green, xyz), glm::dot(blue, xyz)});
  return color / glm::dot(color, glm::dvec3(0.2126729, 0.7151522, 0.0721750));
}

}  // namespace latelight::data
