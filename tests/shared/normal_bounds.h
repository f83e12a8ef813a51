// The maximum error of each normal encoding, derived by hand; shared by the tests of the encodings and of the layouts
// that use them.
#pragma once

#include <cmath>
#include <string>

namespace latelight::shared {

struct NormalBound {
  double radians;   // never exceeded, except for rounding of floats
  double tightest;  // share of it that some direction reaches
};

// The bound of an encoding whose channels have `levels` steps (2^bits - 1), over all directions that it can represent.
// An encoding without a derived bound gets one that no usable encoding exceeds.
inline NormalBound normalBound(const std::string& encoding, double levels) {
  const double zeroCoded = levels - 1;  // steps of channels with a code for 0
  // Rounding moves each coordinate in [-1, 1] by up to 1 / levels. At the center of a face, |o| = 1 / sqrt 3, and the
  // error is (1, 1, -2) / levels along the face: sqrt 6 sqrt 3.
  if (encoding == "octahedral") return {std::sqrt(18.0) / zeroCoded, 0.97};
  // There the codes form a lattice of equilateral triangles of side sqrt 6 sqrt 3 2 / levels / sqrt 3; the circumcenter
  // is farthest from all corners.
  if (encoding == "octahedral_precise") return {std::sqrt(8.0) / zeroCoded, 0.97};
  // (1, 1, 1) / levels, for normals across it.
  if (encoding == "xyz") return {std::sqrt(3.0) / levels, 0.97};
  // At the equator: half a step of pi / levels by half a step of pi / (2 levels).
  if (encoding == "spherical_angles") return {M_PI * std::sqrt(1.25) / levels, 0.97};
  // z rounds to a pole from 1 - 1 / levels.
  if (encoding == "spherical_z") return {std::acos(1 - 1 / levels), 0.97};
  // At the rim, x and y move by 1 / levels each, and 1 - z^2 with them. The rim seldom meets the diagonal of a cell,
  // and with few codes never exactly.
  const double rim = std::sqrt(2.0) / levels;
  if (encoding == "xy_z") return {std::acos(1 - rim), 0.93};
  // There a radius of 1 - r is acos(1 - 2 (1 - (1 - r)^2)) from -Z.
  if (encoding == "spheremap" || encoding == "lambert") return {std::acos(2 * (1 - rim) * (1 - rim) - 1), 0.9};
  const double signedRim = std::sqrt(2.0) / zeroCoded;
  if (encoding == "spheremap_signed") return {std::acos(2 * (1 - signedRim) * (1 - signedRim) - 1), 0.9};
  return {0.25, 0};
}

}  // namespace latelight::shared
