// Generalized cylinders as parametric surfaces.
#include "scene/builtin/tube.h"

namespace latelight::scene::builtin {
namespace {

// The part of the tube's surface around its cross-section that starts at turn `first` and spans `turns`.
Surface section(TubeCurve curve, double first, double turns, dvec2 tiles) {
  return surfaceOf(
      [=, curve = std::move(curve)](double u, double v) {
        const TubePoint p = curve(v);
        const dvec3 along = glm::normalize(p.direction);
        const dvec3 side = glm::normalize(glm::cross(p.normal, along));
        const dvec2 cs = onCircle(first + u * turns);
        return p.position + side * (cs.x * p.across) + glm::cross(along, side) * (cs.y * p.along);
      },
      [tiles](double u, double v) { return dvec2(u, -v) * tiles; });
}

}  // namespace

Patch tube(TubeCurve curve, uint32_t around, uint32_t rows, bool closed, bool pointed, dvec2 tiles) {
  Patch patch;
  patch.columns = around;
  patch.rows = rows;
  patch.closedU = true;
  patch.closedV = closed;
  patch.pointV0 = patch.pointV1 = pointed;
  patch.averaged = true;
  patch.surface = section(std::move(curve), 0, 1, tiles);
  return patch;
}

std::vector<Patch> blade(const TubeCurve& curve, uint32_t across, uint32_t rows) {
  std::vector<Patch> patches;
  for (const double first : {0.0, 0.5}) {
    Patch patch;
    patch.columns = across;
    patch.rows = rows;
    patch.pointV0 = patch.pointV1 = true;
    patch.averaged = true;
    patch.surface = section(curve, first, 0.5, {1, 1});
    patches.push_back(std::move(patch));
  }
  return patches;
}

TubeCurve radialCurve(double turn, std::function<dvec2(double)> curve, std::function<dvec2(double)> halfAxes) {
  const dvec2 cs = onCircle(turn);
  const dvec3 radial(cs.x, 0, -cs.y), up(0, 1, 0);
  return [=](double v) {
    const double h = 1e-4, a = v < h ? 0 : v - h, b = v > 1 - h ? 1 : v + h;
    const dvec2 p = curve(v), d = curve(b) - curve(a), half = halfAxes(v);
    return TubePoint{radial * p.x + up * p.y, radial * d.x + up * d.y, radial * d.y - up * d.x, half.x, half.y};
  };
}

Patch rod(dvec3 from, dvec3 to, double radius, uint32_t around, double tile) {
  const dvec3 along = to - from;
  const double length = glm::length(along);
  const dvec3 normal = std::abs(along.y) > 0.9 * length ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const auto curve = [=](double v) { return TubePoint{v >= 1 ? to : from + along * v, along, normal, radius, radius}; };
  return tube(curve, around, 1, false, false, dvec2(kTau * radius, length) / tile);
}

}  // namespace latelight::scene::builtin
