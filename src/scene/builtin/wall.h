// Flat walls with round-headed openings.
#pragma once

#include "scene/builtin/profile.h"

namespace latelight::scene::builtin {

// A wall's plane: points are origin + s S + y Y, and its front is towards S x Y (cross product).
struct Plane {
  dvec3 origin{0}, s{1, 0, 0}, y{0, 1, 0};
};

struct WallGrid {
  uint32_t arch = 8;    // segments around a half circle, at least 4
  uint32_t across = 2;  // segments from an opening to an edge
  uint32_t up = 4;
};

// Returns a rectangle from s0 to s1 and y0 to y1.
Patch wallPanel(const Plane& plane, double s0, double s1, double y0, double y1, uint32_t across, uint32_t up,
                double tile);

// Returns the wall above an arch: from s = -half to half and y = spring to top, except for the half disc of `radius`
// around (0, spring).
std::vector<Patch> wallAboveArch(const Plane& plane, double half, double spring, double radius, double top,
                                 const WallGrid& grid, double tile);

// Returns a wall from s = -half to half and y = bottom to top with a round-headed opening from sill to `radius` above
// spring.
std::vector<Patch> wallWithWindow(const Plane& plane, double half, double bottom, double top, double sill,
                                  double spring, double radius, const WallGrid& grid, double tile);

// Returns a half disc of `radius` above y = base, with a round hole of radius `hole` around (0, center).
std::vector<Patch> lunette(const Plane& plane, double base, double radius, double center, double hole,
                           const WallGrid& grid, double tile);

// Returns a flat half disc above y = base and the rectangle below it down to `sill`.
std::vector<Patch> roundHeadedPane(const Plane& plane, double sill, double base, double radius, const WallGrid& grid,
                                   double tile);

// Returns the path of a profile over a half circle around (0, spring) of the plane, from +s over the top to -s. The
// profile's x is its distance from the center, and its y points towards the plane's front.
Path archPath(const Plane& plane, double spring, double radius, uint32_t segments);
// Returns the path along the full circle around (0, center).
Path roundPath(const Plane& plane, double center, double radius, uint32_t segments);

}  // namespace latelight::scene::builtin
