// The columns of the arcade: an Attic base, a fluted shaft with entasis, a composite capital with gilded leaves.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/profile.h"
#include "scene/builtin/tube.h"

namespace latelight::scene::builtin::hall {
namespace {

constexpr int kFlutes = 20;
constexpr double kShaftFoot = 0.6, kShaftHead = 3.86, kHeadRadius = 0.3;
const vec3 kSampleColumn(float(kColumnX), 0, float(kBay / 2));  // any column: their surroundings are equal

Path around(const Detail& detail, double normal, uint32_t least, double radius) {
  return circle(Axis{}, detail.segments(normal, least), radius);
}

MeshPlan base(const Detail& detail) {
  MeshPlan plan{"column base", {}, shadeInHall(kSampleColumn), {}};
  Profile plinth(0, 0);
  plinth.line(0, 0.125).line(-0.012, 0.14).line(-0.25, 0.14);
  plan.add(sweepPolygon(plinth, square(0.49), true, detail.segments(1), detail, kMarbleTile));
  Profile torus(0.4, 0.14);
  torus.arc(0.4, 0.3, 2).line(0.4, 0.32).arc(0.385, 0.42, -1.5, 2).line(0.385, 0.44).arc(0.385, 0.55, 2, 2.5);
  torus.line(0.38, 0.57).arc(kColumnRadius, kShaftFoot + 0.005, -0.8, 2);
  plan.add(sweep(torus, around(detail, 26, 8, 0.4), detail, kMarbleTile));
  return plan;
}

// Radius of the shaft at the fraction t of its height. A straight taper would look hollow, so the shaft swells
// (entasis).
double shaftRadius(double t) {
  return kColumnRadius - (kColumnRadius - kHeadRadius) * t * (0.3 + 0.7 * t);
}

double smooth(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

dvec3 shaftPoint(double u, double t, bool fluted) {
  const double s = fluted ? std::abs(sinQuarters(2 * u * kFlutes)) : 0;
  const double ends = smooth(0.012, 0.035, t) * (1 - smooth(0.965, 0.988, t));
  const double radius = shaftRadius(t) - 0.03 * ends * s * std::sqrt(s);
  const dvec2 cs = onCircle(u);
  return {radius * cs.x, kShaftFoot + (kShaftHead - kShaftFoot) * t, -radius * cs.y};
}

MeshPlan shaft(const Detail& detail) {
  MeshPlan plan{"column shaft", {}, shadeInHall(kSampleColumn), {}};
  const bool fluted = detail.scale > 0.35;
  const struct {
    double from, to;
    uint32_t rows;
  } zones[] = {{0, 0.05, detail.segments(3)}, {0.05, 0.95, detail.segments(7, 1)}, {0.95, 1, detail.segments(3)}};
  for (const auto& zone : zones) {
    Patch patch;
    patch.columns = fluted ? kFlutes * detail.segments(5, 3) : detail.segments(40, 8);
    patch.rows = zone.rows;
    patch.closedU = true;
    const auto height = [zone](double v) { return v >= 1 ? zone.to : zone.from + (zone.to - zone.from) * v; };
    patch.surface = surfaceOf(
        [=](double u, double v) { return shaftPoint(u, height(v), fluted); },
        [height](double u, double v) { return dvec2(u * 2, -height(v) * (kShaftHead - kShaftFoot) / kMarbleTile); });
    plan.add(std::move(patch));
  }
  // The flutes' own occlusion is stronger farther in.
  plan.shade = [hall = plan.shade](vec3 p, vec3 n) {
    const double t = std::clamp((p.y - kShaftFoot) / (kShaftHead - kShaftFoot), 0.0, 1.0);
    const double depth = shaftRadius(t) - std::sqrt(double{p.x} * p.x + double{p.z} * p.z);
    return hall(p, n) * float(1 - 0.25 * std::clamp(depth / 0.03, 0.0, 1.0));
  };
  return plan;
}

MeshPlan capital(const Detail& detail) {
  MeshPlan plan{"column capital", {}, shadeInHall(kSampleColumn), {}};
  Profile bell(kHeadRadius, kShaftHead - 0.01);
  bell.line(0.305, kShaftHead).arc(0.305, kShaftHead + 0.06, 2, 2).line(0.29, kShaftHead + 0.065);
  bell.curve({{0.285, 4.0}, {0.3, 4.2}, {0.36, 4.31}}, 2).line(0.38, 4.35);
  plan.add(sweep(bell, around(detail, 22, 8, 0.3), detail, kMarbleTile));
  Profile abacus(-0.3, 4.35);
  abacus.line(-0.05, 4.35).arc(-0.005, 4.41, 1, 2).line(-0.005, 4.425).line(0.02, 4.43).line(0.02, 4.49);
  abacus.line(0.01, kColumnTop).line(-0.2, kColumnTop);
  plan.add(sweepPolygon(abacus, square(0.45), true, 1, detail, kMarbleTile));
  return plan;
}

// A leaf that starts on the bell at height `foot`, rises and curls outwards.
std::vector<Patch> leaf(const Detail& detail, double turn, double foot, double height, double reach) {
  const auto curve = [=](double v) {
    const double curl = smooth(0.55, 1, v);
    return dvec2(0.293 + 0.03 * v + reach * curl * (0.35 + 0.65 * v), foot + height * (v - 0.42 * curl * curl * v));
  };
  const auto halfAxes = [](double v) {
    const double w = std::sqrt(std::max(0.0, v * (1 - v))) * 2;
    return dvec2(0.098 * w * (1 - 0.35 * v), 0.014 * w);
  };
  return blade(radialCurve(turn, curve, halfAxes), detail.segments(3, 2), detail.segments(7, 3));
}

// A scroll under each corner of the abacus.
Patch volute(const Detail& detail, double turn) {
  const auto curve = [](double v) {
    const dvec2 eye(0.475, 4.255);
    if (v < 0.3) {  // the stalk
      const double t = v / 0.3;
      return dvec2(0.3 + 0.175 * t * t, 4.12 + (4.255 + 0.085 - 4.12) * t * (2 - t));
    }
    const double t = (v - 0.3) / 0.7;
    const double radius = 0.085 - 0.062 * t;
    const dvec2 cs = onCircle(0.25 - 1.6 * t);
    return eye + radius * cs;
  };
  const auto halfAxes = [](double v) {
    const double w = std::min(1.0, 12 * std::min(v, 1 - v));
    const double taper = std::sqrt(std::max(0.0, w)) * (1 - 0.35 * v);
    return dvec2(0.036 * taper, 0.017 * taper);
  };
  return tube(radialCurve(turn, curve, halfAxes), detail.segments(6, 4), detail.segments(24, 16), false, true);
}

MeshPlan ornament(const Detail& detail) {
  MeshPlan plan{"column leaves", {}, shadeInHall(kSampleColumn), {}};
  for (int i = 0; i < 8; ++i) {
    if (detail.scale < 0.25 && i % 2) continue;
    plan.add(leaf(detail, i / 8.0, 3.92, 0.24, 0.085));
    plan.add(leaf(detail, (i + 0.5) / 8, 3.95, 0.44, 0.13));
  }
  if (detail.scale < 0.25) return plan;
  for (int i = 0; i < 4; ++i) plan.add(volute(detail, (i + 0.5) / 4));
  return plan;
}

// The block between capital and arch, like a piece of entablature.
MeshPlan impost(const Detail& detail) {
  MeshPlan plan{"impost block", {}, shadeInHall(kSampleColumn), {}};
  Profile block(-0.2, kColumnTop);
  block.line(-0.02, kColumnTop).line(-0.02, 4.56).line(-0.01, 4.565).line(-0.01, 4.62).arc(0.012, 4.65, -1, 2);
  block.line(-0.025, 4.655).line(-0.025, 4.82).arc(0.03, 4.88, 1, 2).line(0.055, 4.885).line(0.055, 4.93);
  block.arc(0.085, 4.97, 1, 2).line(0.085, kArchSpring).line(-0.3, kArchSpring);
  plan.add(sweepPolygon(block, square(0.375), true, detail.segments(1), detail, kPlasterTile));
  return plan;
}

}  // namespace

void addColumns(HallBuilder& hall) {
  const uint32_t meshes[] = {hall.mesh(base(hall.detail)), hall.mesh(shaft(hall.detail)),
                             hall.mesh(capital(hall.detail)), hall.mesh(ornament(hall.detail)),
                             hall.mesh(impost(hall.detail))};
  int number = 0;
  for (int side = 0; side < 2; ++side) {
    for (int boundary = kBays; boundary >= 0; --boundary) {
      const mat4 where = rotatedAt(side ? -kColumnX : kColumnX, 0, bayBoundary(boundary), 2 * side);
      const uint32_t group = hall.group(fmt::format("column {}", ++number), SceneBuilder::kRoot, where);
      const bool red = boundary % 2 == 0;
      hall.place("base", group, meshes[0], HallMaterial::Marble);
      hall.place("shaft", group, meshes[1], red ? HallMaterial::RedMarble : HallMaterial::GreenMarble);
      hall.place("capital", group, meshes[2], HallMaterial::Marble);
      hall.place("leaves", group, meshes[3], HallMaterial::Gilt);
      hall.place("impost", group, meshes[4], HallMaterial::Trim);
    }
  }
}

}  // namespace latelight::scene::builtin::hall
