// Bodies around a curve: leaves, scrolls, chains, knots.
#pragma once

#include <functional>

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin {

// A curve's point, its direction (any length), and a normal about across it; the body's section has the half axes
// `across` (along direction x normal) and `along` (along the normal). An end where both are 0 is a point.
struct TubePoint {
  dvec3 position, direction, normal;
  double across, along;
};
using TubeCurve = std::function<TubePoint(double v)>;

// `closed`: v = 1 coincides with v = 0; else the ends are open unless `pointed`. uv: x around, y along, in tiles.
Patch tube(TubeCurve curve, uint32_t around, uint32_t rows, bool closed, bool pointed, dvec2 tiles = {1, 1});

// A pointed tube with an edge along each side, like a leaf: its two faces don't share normals.
std::vector<Patch> blade(const TubeCurve& curve, uint32_t across, uint32_t rows);

// A curve in the half plane of angle `turn` around +Y: (distance from the axis, height) by v, and half axes by v.
TubeCurve radialCurve(double turn, std::function<dvec2(double)> curve, std::function<dvec2(double)> halfAxes);

// A straight round rod, open at its ends.
Patch rod(dvec3 from, dvec3 to, double radius, uint32_t around, double tile = 1);

}  // namespace latelight::scene::builtin
