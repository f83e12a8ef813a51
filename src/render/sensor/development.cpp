#include "render/sensor/development.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "shared/tonemap.h"

namespace latelight::render {

namespace {

double responseAt(const Response& response, double signal) {
  signal = std::clamp(signal, 0.0, 1.0);
  if (response.gamma > 0) return std::pow(signal, 1 / response.gamma);
  const double place = signal * static_cast<double>(response.values.size() - 1);
  const size_t i = std::min(static_cast<size_t>(place), response.values.size() - 2);
  const double share = place - static_cast<double>(i);
  return (1 - share) * response.values[i] + share * response.values[i + 1];
}

glm::vec3 codeOf(glm::vec3 color, const Settings& s) {
  if (s.response.isDisplay()) {
    const glm::vec3 shown = shared::tonemap(indexOf(s.tonemap), glm::max(color, glm::vec3(0)));
    return shared::srgbFromLinear(shown);
  }
  glm::vec3 code;
  for (int k = 0; k < 3; ++k) code[k] = static_cast<float>(responseAt(s.response, color[k]));
  return code;
}

uint8_t rounded(float unit) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(unit, 0.0f, 1.0f)));
}

}  // namespace

std::vector<uint8_t> developed(const std::vector<float>& rgba, const Settings& s) {
  std::vector<uint8_t> picture(rgba.size());
  parallelFor(rgba.size() / 4, size_t{1} << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float* from = &rgba[4 * i];
      const uint8_t alpha = rounded(from[3]);
      if (alpha == 0) continue;  // no color, for viewers that ignore alpha
      const glm::vec3 code = codeOf(glm::vec3(from[0], from[1], from[2]) / from[3], s);
      for (int k = 0; k < 3; ++k) picture[4 * i + static_cast<size_t>(k)] = rounded(code[k]);
      picture[4 * i + 3] = alpha;
    }
  });
  return picture;
}

}  // namespace latelight::render
