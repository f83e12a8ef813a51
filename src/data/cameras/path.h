// Smooth curves through places and rotations.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

namespace latelight::data {

// From p1 (share 0) to p2 (share 1), without loops and overshoots (centripetal Catmull-Rom curves: Yuksel, Schaefer and
// Keyser 2011, "Parameterization and applications of Catmull-Rom curves").
glm::dvec3 catmullRom(const std::array<glm::dvec3, 4>& points, double share);

// Unit quaternions w x y z. Slerp turns evenly from one to the other, the way that their signs say.
glm::dvec4 slerp(glm::dvec4 a, glm::dvec4 b, double share);

// The turn at the middle one that lets squad() pass it smoothly (Shoemake 1987, "Quaternion calculus and fast
// animation").
glm::dvec4 squadControl(glm::dvec4 before, glm::dvec4 at, glm::dvec4 after);
// From a to b, with their controls.
glm::dvec4 squad(glm::dvec4 a, glm::dvec4 controlA, glm::dvec4 controlB, glm::dvec4 b, double share);

}  // namespace latelight::data
