// Smooth interpolation of positions (centripetal Catmull-Rom splines) and rotations (slerp, squad).
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

namespace latelight::data {

// Interpolates from points[1] (share 0) to points[2] (share 1) by a centripetal Catmull-Rom curve, which has no loops
// or overshoots (Yuksel, Schaefer and Keyser 2011, "Parameterization and applications of Catmull-Rom curves").
glm::dvec3 catmullRom(const std::array<glm::dvec3, 4>& points, double share);

// Spherical linear interpolation of unit quaternions w x y z, with constant angular velocity. The signs of the
// quaternions decide the direction of rotation.
glm::dvec4 slerp(glm::dvec4 a, glm::dvec4 b, double share);

// Returns the control rotation at `at` for which squad() is smooth there (Shoemake 1987, "Quaternion calculus and fast
// animation").
glm::dvec4 squadControl(glm::dvec4 before, glm::dvec4 at, glm::dvec4 after);
// Spherical cubic interpolation (squad) from a to b, with the control rotations of both.
glm::dvec4 squad(glm::dvec4 a, glm::dvec4 controlA, glm::dvec4 controlB, glm::dvec4 b, double share);

}  // namespace latelight::data
