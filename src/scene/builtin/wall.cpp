// Flat walls with round-headed openings as patches without T-junctions.
#include "scene/builtin/wall.h"

#include <algorithm>

namespace latelight::scene::builtin {
namespace {

// Returns a flat patch from its (s, y) positions; u and v must have the same orientation as s and y.
Patch flat(const Plane& plane, uint32_t columns, uint32_t rows, double tile,
           std::function<dvec2(double, double)> position) {
  Patch patch;
  patch.columns = columns;
  patch.rows = rows;
  const dvec3 normal = glm::cross(plane.s, plane.y);
  patch.surface = [=, position = std::move(position)](double u, double v) {
    const dvec2 p = position(u, v);
    SurfacePoint point;
    point.position = plane.origin + plane.s * p.x + plane.y * p.y;
    point.normal = normal;
    point.tangent = plane.s;
    point.uv = dvec2(p.x, -p.y) / tile;
    return point;
  };
  return patch;
}

dvec2 mixed(dvec2 a, dvec2 b, double t) {
  return t <= 0 ? a : t >= 1 ? b : a + (b - a) * t;
}

// Returns the patch between an arc around (0, center) and a straight line outside it, parameterized by the fraction v
// of the arc's angle from `first` to `last` turns.
Patch fan(const Plane& plane, double center, double radius, double first, double last, dvec2 from, dvec2 to,
          uint32_t across, uint32_t along, double tile) {
  return flat(plane, across, along, tile, [=](double u, double v) {
    const dvec2 circle = dvec2(0, center) + radius * onCircle(first + (last - first) * v);
    return mixed(circle, mixed(from, to, v), u);
  });
}

}  // namespace

Patch wallPanel(const Plane& plane, double s0, double s1, double y0, double y1, uint32_t across, uint32_t up,
                double tile) {
  return flat(plane, across, up, tile, [=](double u, double v) {
    return dvec2(mixed({s0, 0}, {s1, 0}, u).x, mixed({y0, 0}, {y1, 0}, v).x);
  });
}

std::vector<Patch> wallAboveArch(const Plane& plane, double half, double spring, double radius, double top,
                                 const WallGrid& grid, double tile) {
  // A boundary in the corner's own direction keeps quads upright. At least one segment is on each side of it.
  const double corner = turnsOf(top - spring, half);
  const uint32_t side = std::max(1u, static_cast<uint32_t>(2 * corner * grid.arch + 0.5));
  const uint32_t above = std::max(1u, grid.arch - std::min(grid.arch - 1, 2 * side));
  const dvec2 low(half, spring), high(half, top), farHigh(-half, top), farLow(-half, spring);
  return {fan(plane, spring, radius, 0, corner, low, high, grid.across, side, tile),
          fan(plane, spring, radius, corner, 0.5 - corner, high, farHigh, grid.across, above, tile),
          fan(plane, spring, radius, 0.5 - corner, 0.5, farHigh, farLow, grid.across, side, tile)};
}

std::vector<Patch> wallWithWindow(const Plane& plane, double half, double bottom, double top, double sill,
                                  double spring, double radius, const WallGrid& grid, double tile) {
  std::vector<Patch> patches = wallAboveArch(plane, half, spring, radius, top, grid, tile);
  patches.push_back(wallPanel(plane, -half, -radius, sill, spring, grid.across, grid.up, tile));
  patches.push_back(wallPanel(plane, radius, half, sill, spring, grid.across, grid.up, tile));
  // Below the opening, columns continue those next to and under it, so that there are no T-junctions.
  if (sill <= bottom) return patches;
  patches.push_back(wallPanel(plane, -half, -radius, bottom, sill, grid.across, grid.up, tile));
  patches.push_back(wallPanel(plane, -radius, radius, bottom, sill, grid.across, grid.up, tile));
  patches.push_back(wallPanel(plane, radius, half, bottom, sill, grid.across, grid.up, tile));
  return patches;
}

std::vector<Patch> lunette(const Plane& plane, double base, double radius, double center, double hole,
                           const WallGrid& grid, double tile) {
  // Rays from the hole's center end at the half disc's rim or at its base; its two corners are patch boundaries.
  const double h = center - base, corner = 1 - turnsOf(h, radius);  // angle of the ray to (radius, base)
  const auto ring = [=](double from, double to, bool rim) {
    return flat(plane, grid.across, rim ? 2 * grid.arch : grid.arch, tile, [=](double u, double v) {
      const dvec2 d = onCircle(from + (to - from) * v);
      double reach = rim ? -d.y * h + std::sqrt(std::max(0.0, radius * radius - h * h * d.x * d.x)) : -h / d.y;
      return dvec2(0, center) + d * (hole + (reach - hole) * u);
    });
  };
  return {ring(corner - 1, 1.5 - corner, true), ring(1.5 - corner, corner, false)};
}

std::vector<Patch> roundHeadedPane(const Plane& plane, double sill, double base, double radius, const WallGrid& grid,
                                   double tile) {
  Patch head = flat(plane, 1, grid.arch, tile,
                    [=](double u, double v) { return dvec2(0, base) + radius * u * onCircle(0.5 * v); });
  head.pointU0 = true;
  return {head, wallPanel(plane, -radius, 0, sill, base, 1, grid.up, tile),
          wallPanel(plane, 0, radius, sill, base, 1, grid.up, tile)};
}

Path archPath(const Plane& plane, double spring, double radius, uint32_t segments) {
  return circleArc({plane.origin + plane.y * spring, glm::cross(plane.s, plane.y), plane.s}, 0, 0.5, segments, radius);
}

Path roundPath(const Plane& plane, double center, double radius, uint32_t segments) {
  return circle({plane.origin + plane.y * center, glm::cross(plane.s, plane.y), plane.s}, segments, radius);
}

}  // namespace latelight::scene::builtin
