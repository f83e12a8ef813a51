// The range in which a lens's distortion is monotonic, and its projection defined (LensProjection).
#pragma once

#include "scene/lens.h"

namespace latelight::scene {

// Returns the first turning point: of the squared distance from the axis at 1 m (opencv), of the angle to the axis
// (fisheye), or of the distance from the principal point (ftheta). Infinite if there is none; 0 for other models.
double turningPoint(const Lens& lens);

}  // namespace latelight::scene
