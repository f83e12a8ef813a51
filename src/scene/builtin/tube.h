// Generalized cylinders around a curve: leaves, scrolls, chains, knots.
#pragma once

#include <functional>

#include "scene/builtin/mesh_plan.h"

namespace latelight::scene::builtin {

// A point of a curve, its direction (of any length), and a normal approximately perpendicular to it. The cross-section
// is an ellipse with the half axes `across` (along direction x normal) and `along` (along the normal). An end where
// both are 0 is a point.
struct TubePoint {
  dvec3 position, direction, normal;
  double across, along;
};
using TubeCurve = std::function<TubePoint(double v)>;

// `closed`: v = 1 coincides with v = 0; otherwise the ends are open unless `pointed`. uv is in tiles: x around, y
// along.
Patch tube(TubeCurve curve, uint32_t around, uint32_t rows, bool closed, bool pointed, dvec2 tiles = {1, 1});

// Returns a pointed tube with an edge along each side, like a leaf: its two faces don't share normals.
std::vector<Patch> blade(const TubeCurve& curve, uint32_t across, uint32_t rows);

// Returns a curve in the half plane at angle `turn` around +Y. `curve` maps v to (distance from the axis, height),
// `halfAxes` maps v to the half axes.
TubeCurve radialCurve(double turn, std::function<dvec2(double)> curve, std::function<dvec2(double)> halfAxes);

// Returns a straight round rod, open at its ends.
Patch rod(dvec3 from, dvec3 to, double radius, uint32_t around, double tile = 1);

}  // namespace latelight::scene::builtin
