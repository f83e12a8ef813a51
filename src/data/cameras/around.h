// Places around a target by two angles.
#pragma once

#include "data/cameras/source.h"

namespace latelight::data {

// A direction, and the pose of a camera there that looks back: nothing degenerates at the poles. Azimuth 0 is the
// scene's front and grows towards its right; at elevations of +-90 degrees the picture's up is away from azimuth.
struct Around {
  glm::dvec3 outwards;
  glm::dmat4 pose(glm::dvec3 centre, double distance) const;

  glm::dvec3 right, up;
};
// Turns of the whole circle, and the elevation's sine.
Around around(const SceneAxes& axes, double azimuth, double sineOfElevation);

}  // namespace latelight::data
