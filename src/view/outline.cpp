// Outline of the selection: colors each pixel outside of the object that is within a few pixels of it.
#include "view/outline.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"

namespace latelight::view {

namespace {

constexpr std::array<uint8_t, 4> kOrange{255, 150, 30, 255};

}  // namespace

void drawOutline(output::Picture& picture, const output::AovImage& ids, uint32_t id) {
  const auto width = static_cast<int>(ids.width), height = static_cast<int>(ids.height);
  const int reach = std::max(1, height / 360);  // a constant fraction of the picture's height
  const auto isSelected = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < width && y < height && ids.ids[static_cast<size_t>(y) * ids.width + x] == id;
  };
  const auto isNear = [&](int x, int y) {
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx)
        if (isSelected(x + dx, y + dy)) return true;
    return false;
  };
  parallelFor(ids.height, 32, [&](size_t first, size_t end) {
    for (int y = static_cast<int>(first); y < static_cast<int>(end); ++y)
      for (int x = 0; x < width; ++x)
        if (!isSelected(x, y) && isNear(x, y))
          std::copy(kOrange.begin(), kOrange.end(), &picture.rgba[4 * (static_cast<size_t>(y) * ids.width + x)]);
  });
}

}  // namespace latelight::view
