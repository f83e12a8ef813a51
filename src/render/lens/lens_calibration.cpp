#include "render/lens/lens_calibration.h"

#include <algorithm>

#include "scene/lens_range.h"

namespace latelight::render {

shared::LensCalibration calibrationOf(const scene::Lens& lens, uint32_t width, uint32_t height) {
  const scene::Lens l = scene::scaledTo(lens, width, height);
  const auto number = [](double value) { return static_cast<float>(value); };
  const auto four = [&](size_t first) {
    const auto& k = l.distortion;
    return glm::vec4(k[first], k[first + 1], k[first + 2], k[first + 3]);
  };
  return {.model = static_cast<uint32_t>(l.model),
          .width = number(l.width),
          .height = number(l.height),
          .fx = number(l.fx),
          .fy = number(l.fy),
          .cx = number(l.cx),
          .cy = number(l.cy),
          .limit = number(std::min(scene::turningPoint(l), 1e9)),
          .low = four(0),
          .high = four(4)};
}

}  // namespace latelight::render
