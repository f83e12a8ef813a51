#include "view/split.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/parallel.h"

namespace latelight::view {

output::Picture splitPicture(const output::Picture& left, const output::Picture& right, const SetSplit& split) {
  output::Picture picture = left;
  const auto begin = static_cast<uint32_t>(std::lround(std::clamp(split.at, 0.0, 1.0) * left.width));
  const auto mix = [&](uint8_t* to, const uint8_t* from) {
    for (int c = 0; c < 3; ++c)
      to[c] = static_cast<uint8_t>(std::min(std::abs(to[c] - from[c]) * split.amplification, 255.0));
    to[3] = 255;
  };
  const auto row = [&](uint32_t y) {
    const uint64_t fromY = uint64_t{y} * right.height / left.height;
    for (uint32_t x = split.mode == SetSplit::Slider ? begin : 0; x < left.width; ++x) {
      const uint8_t* from = &right.rgba[4 * (fromY * right.width + uint64_t{x} * right.width / left.width)];
      uint8_t* to = &picture.rgba[4 * (uint64_t{y} * left.width + x)];
      if (split.mode == SetSplit::Slider)
        std::copy_n(from, 4, to);
      else
        mix(to, from);
    }
  };
  parallelFor(left.height, 64, [&](size_t first, size_t end) {
    for (size_t y = first; y < end; ++y) row(static_cast<uint32_t>(y));
  });
  return picture;
}

}  // namespace latelight::view
