// Transforms of the public API, for tests.
#pragma once

#include <latelight/latelight.h>

namespace latelight::test {

// Returns a uniform scale, then a translation.
inline Transform placed(double x, double y, double z, double size = 1) {
  return {size, 0, 0, x, 0, size, 0, y, 0, 0, size, z, 0, 0, 0, 1};
}

}  // namespace latelight::test
