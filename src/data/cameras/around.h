// Camera poses around a target in spherical coordinates.
#pragma once

#include "data/cameras/source.h"

namespace latelight::data {

// A direction from the target, and the axes of a camera in that direction that looks back. Nothing degenerates at the
// poles. Azimuth 0 is the scene's front and grows towards its right. At an elevation of 90 degrees the picture's up
// points away from the azimuth's direction, at -90 degrees towards it.
struct Around {
  glm::dvec3 outwards;
  glm::dmat4 pose(glm::dvec3 center, double distance) const;

  glm::dvec3 right, up;
};
// `azimuth` is in turns of the full circle; the elevation is given by its sine.
Around around(const SceneAxes& axes, double azimuth, double sineOfElevation);

}  // namespace latelight::data
