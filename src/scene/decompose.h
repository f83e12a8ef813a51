// Decomposes transforms into translations, rotations and scales.
#pragma once

#include "scene/animation.h"

namespace latelight::scene {

constexpr double kRoundingOfDoubles = 1e-12;  // of decompositionError()

// Returns the part of an affine transform that a translation, a rotation and a scale represent, and the transform
// itself in `matrix`. `scaleSigns`: 1 or -1 for each axis, the signs of the scale; if they do not agree with the
// transform, it has no scale below 0, except for that of x if it mirrors.
RigNode decomposeTransform(const glm::dmat4& matrix, glm::dvec3 scaleSigns = glm::dvec3(1));

// Returns 1 or -1 for each axis.
glm::dvec3 signsOf(glm::dvec3 scale);

// Returns the largest error of a decomposition, relative to the largest number of its matrix.
double decompositionError(const RigNode& node);

// Returns a node with this transform. It is a translation, a rotation and a scale if a matrix would not be enough: glTF
// has no matrices that scale an axis to 0 (3.5.3), and a matrix does not state which axes it mirrors. Otherwise, or if
// the transform shears, it is the matrix, whose numbers are exact.
RigNode nodeWithTransform(const glm::dmat4& matrix, glm::dvec3 scaleSigns);

}  // namespace latelight::scene
