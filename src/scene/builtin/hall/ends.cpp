// The hall's ends: the apse with its mosaic and steps, the door opposite it, and a rose window in each lunette.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/tube.h"
#include "scene/builtin/wall.h"

namespace latelight::scene::builtin::hall {
namespace {

// An end in its own frame: the wall's face is the plane z = 0, and the hall is towards +Z. The west end is rotated.
const Plane kFace{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
const vec3 kEast(0, 0, -float(kHalfLength));
constexpr double kHalfNave = kColumnX;            // the wall continues behind the arcades
constexpr double kInside = kApseRadius + 0.0625;  // radius of the apse's walls, recessed from the arch's edge
constexpr double kApseFloor = kApseSteps * kApseStep;

WallGrid wallGrid(const Detail& detail) {
  return {detail.segments(16, 6), detail.segments(3, 1), detail.segments(5, 1)};
}

MeshPlan endWall(const Detail& detail, const char* name, double spring, double radius) {
  MeshPlan plan{name, {}, shadeInHall(kEast), {}};
  plan.add(wallWithWindow(kFace, kHalfNave, 0, kVaultSpring, 0, spring, radius + 0.12, wallGrid(detail), kAshlarTile));
  plan.add(
      lunette(kFace, kVaultSpring, kVaultRadius + 0.15, kRoseHeight, kRoseRadius + 0.1, wallGrid(detail), kAshlarTile));
  for (const double side : {-1.0, 1.0}) {
    const double a = side < 0 ? -kOuterX : kColumnX, b = side < 0 ? -kColumnX : kOuterX;
    const uint32_t n = detail.segments(5, 1);
    plan.add(wallPanel(kFace, a, b, 0, kArchSpring + kAisleRise + 0.2, n, n, kAshlarTile));
    plan.add(wallPanel(kFace, a, b, kGalleryFloor - 0.1, kGalleryTop, n, n, kAshlarTile));
  }
  return plan;
}

// A string course across the nave where the vault begins.
MeshPlan endCornice(const Detail& detail) {
  MeshPlan plan{"end cornice", {}, {}, {}};
  Profile p(-0.03, kVaultSpring - 0.25);
  p.line(0.03, kVaultSpring - 0.25).arc(0.12, kVaultSpring - 0.12, -1, 3).line(0.15, kVaultSpring - 0.115);
  p.line(0.15, kVaultSpring - 0.04).line(0.14, kVaultSpring).line(-0.03, kVaultSpring + 0.02);
  plan.add(sweep(p, straight({-kHalfNave, 0, 0}, {kHalfNave, 0, 0}, {0, 0, 1}, {0, 1, 0}, detail.segments(6)), detail,
                 kPlasterTile));
  return plan;
}

// A molded frame around a round-headed opening down to y = foot, `depth` deep.
MeshPlan portal(const Detail& detail, const char* name, double foot, double spring, double radius, double depth) {
  MeshPlan plan{name, {}, shadeInHall(kEast), {}};
  const double r = radius;
  Profile p(r + 0.45, -0.01);
  p.line(r + 0.45, 0.1).arc(r + 0.36, 0.14, 0.9, 2).line(r + 0.32, 0.14).arc(r + 0.26, 0.08, -0.9, 2);
  p.line(r + 0.18, 0.08).line(r + 0.175, 0.06).line(r + 0.08, 0.06).arc(r + 0.02, 0.03, 1.6, 3).line(r, 0.02);
  p.line(r, 0).line(r, -depth).line(r + 0.1, -depth);
  plan.add(sweep(p, archPath(kFace, spring, r, detail.segments(30, 12)), detail, kPlasterTile));
  const uint32_t up = detail.segments(5);
  plan.add(sweep(p, straight({0, foot, 0}, {0, spring, 0}, {1, 0, 0}, {0, 0, 1}, up), detail, kPlasterTile));
  plan.add(sweep(p, straight({0, spring, 0}, {0, foot, 0}, {-1, 0, 0}, {0, 0, 1}, up), detail, kPlasterTile));
  return plan;
}

// A gilded rope molding around the apse's arch.
MeshPlan archBead(const Detail& detail) {
  MeshPlan plan{"apse arch bead", {}, {}, {}};
  const double r = kApseRadius + 0.22;
  const auto curve = [r](double v) {
    const dvec2 cs = onCircle(0.5 * v);
    return TubePoint{{r * cs.x, kApseSpring + r * cs.y, 0.08}, {-cs.y, cs.x, 0}, {0, 0, 1}, 0.03, 0.03};
  };
  plan.add(tube(curve, detail.segments(6, 4), detail.segments(40, 16), false, false, {1, 30}));
  for (const double s : {-1.0, 1.0})
    plan.add(rod({s * r, kApseFloor, 0.08}, {s * r, kApseSpring, 0.08}, 0.03, detail.segments(6, 4)));
  return plan;
}

Path roundTheApse(const Detail& detail) {
  return circleArc(Axis{}, 0, 0.5, detail.segments(24, 10), kInside);
}

// A quarter of a sphere with its poles at the arch's two springing points, where the frame hides them.
MeshPlan semidome(const Detail& detail) {
  MeshPlan plan{"apse mosaic", {}, {}, {}};
  Patch patch;
  patch.columns = detail.segments(26, 10);
  patch.rows = detail.segments(14, 6);
  patch.pointU0 = patch.pointU1 = true;
  const auto direction = [](double u, double v) {
    const dvec2 along = onCircle(0.5 * u), around = onCircle(0.25 * (1 - v));
    return dvec3(-along.x, along.y * around.y, -along.y * around.x);
  };
  patch.surface = surfaceOf(
      [=](double u, double v) { return dvec3(0, kApseSpring, 0) + kInside * direction(u, 1 - v); },
      // Lambert azimuthal equal-area projection about the center; distortion is small within a quarter sphere.
      [=](double u, double v) {
        const dvec3 d = direction(u, 1 - v);
        const double x = d.x, y = (d.y + d.z) * std::sqrt(0.5), towards = (d.y - d.z) * std::sqrt(0.5);
        return dvec2(x, -y) * (kApseRadius * std::sqrt(2 / (1 + towards)) / kMosaicTile);
      });
  plan.add(std::move(patch));
  plan.shade = [](vec3 p, vec3) { return 0.65f + 0.35f * std::clamp((p.y - float(kApseSpring)) / 1.2f, 0.0f, 1.0f); };
  return plan;
}

MeshPlan apseCornice(const Detail& detail) {
  MeshPlan plan{"apse cornice", {}, {}, {}};
  // Inside a circle the profile runs downwards, and its x is the distance from the axis.
  const double r = kInside, y = kApseSpring;
  Profile p(r + 0.02, y + 0.02);
  p.line(r - 0.26, y).line(r - 0.26, y - 0.06).line(r - 0.23, y - 0.065).arc(r - 0.14, y - 0.17, -0.9, 3);
  p.line(r - 0.12, y - 0.175).line(r - 0.12, y - 0.25).arc(r - 0.03, y - 0.34, -1, 3).line(r - 0.03, y - 0.48);
  p.line(r + 0.01, y - 0.485);
  plan.add(sweep(p, roundTheApse(detail), detail, kPlasterTile));
  Profile base(r + 0.01, 1.75);
  base.line(r - 0.04, 1.74).arc(r - 0.04, 1.66, 2, 2).line(r - 0.02, 1.655).line(r + 0.01, 1.64);
  plan.add(sweep(base, roundTheApse(detail), detail, kPlasterTile));
  Profile skirting(r, kApseFloor + 0.3);
  skirting.line(r - 0.03, kApseFloor + 0.28).arc(r - 0.07, kApseFloor + 0.2, -1, 2).line(r - 0.07, kApseFloor - 0.02);
  plan.add(sweep(skirting, roundTheApse(detail), detail, kPlasterTile));
  return plan;
}

MeshPlan apseWall(const Detail& detail, const char* name, double high, double low, double tile) {
  MeshPlan plan{name, {}, shadeInHall(kEast), {}};
  Profile p(kInside, high);
  p.line(kInside, low).segments(6, 2);
  plan.add(sweep(p, roundTheApse(detail), detail, tile));
  plan.shade = [](vec3 at, vec3) {
    const float above = (at.y - float(kApseFloor)) / 0.8f, below = (float(kApseSpring) - at.y) / 1.2f;
    return 0.6f + 0.4f * std::clamp(std::min(above, below), 0.0f, 1.0f);
  };
  return plan;
}

// The responds at the apse's two ends, where its moldings stop.
MeshPlan apseResponds(const Detail& detail) {
  MeshPlan plan{"apse responds", {}, {}, {}};
  const double r = kApseRadius, top = kApseSpring - 0.47;
  for (const double side : {-1.0, 1.0}) {
    const auto block = [&](double in, double low, double high, double front) {
      const double a = side * (r - in), b = side * (r + 0.15);
      plan.add(box({std::min(a, b), low, -0.3}, {std::max(a, b), high, front}, detail.segments(1), kPlasterTile));
    };
    block(0.15, kApseFloor - 0.1, kApseFloor + 0.34, 0.012);
    block(0.11, kApseFloor + 0.2, top + 0.05, 0.01);
    block(0.3, top - 0.02, kApseSpring + 0.03, 0.014);
  }
  return plan;
}

// Flat strips between the apse's marble slabs.
MeshPlan apsePilasters(const Detail& detail) {
  MeshPlan plan{"apse pilasters", {}, {}, {}};
  const double r = kInside, top = kApseSpring - 0.47;
  Profile p(r - 0.02, top);
  p.line(r - 0.12, top).line(r - 0.12, top - 0.06).arc(r - 0.08, top - 0.14, -1, 2).line(r - 0.08, top - 0.24);
  p.line(r - 0.065, top - 0.25).line(r - 0.065, kApseFloor + 0.34).segments(4, 1).line(r - 0.09, kApseFloor + 0.3);
  p.line(r - 0.09, kApseFloor - 0.02);
  for (int i = 0; i < 6; ++i) {
    const double middle = 0.035 + i * 0.43 / 5, half = 0.011;
    plan.add(sweep(p, circleArc(Axis{}, middle - half, middle + half, 2, kInside), detail, kPlasterTile));
    for (const double side : {-1.0, 1.0}) {
      const dvec2 cs = onCircle(middle + side * half);
      const dvec3 in(cs.x * (r - 0.065), 0, -cs.y * (r - 0.065)), out(cs.x * r, 0, -cs.y * r);
      const dvec3 low(0, kApseFloor, 0), high(0, top - 0.2, 0);
      plan.add(side < 0 ? quad(in + low, out + low, out + high, in + high, 1, 4, kPlasterTile)
                        : quad(out + low, in + low, in + high, out + high, 1, 4, kPlasterTile));
    }
  }
  return plan;
}

MeshPlan steps(const Detail& detail) {
  MeshPlan plan{"apse steps", {}, shadeInHall(kEast), {}};
  const double first = kApseRadius + 0.35 + 0.35 * kApseSteps;
  Profile p(first, 0);
  for (int i = 0; i < kApseSteps; ++i) {
    const double r = first - 0.35 * i, y = kApseStep * (i + 1);
    p.line(r, y - 0.045).line(r + 0.02, y - 0.04).arc(r + 0.02, y, 2, 2);
    if (i + 1 < kApseSteps) p.line(r - 0.35, y);
  }
  const Axis axis{{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  plan.add(sweep(p, circleArc(axis, 0, 0.5, detail.segments(40, 14), first), detail, kMarbleTile));
  // The apse's floor fills the circle within the last step's edge.
  Profile floor(first - 0.35 * (kApseSteps - 1) + 0.02, kApseFloor);
  floor.line(0, kApseFloor).segments(5, 1);
  plan.add(sweep(floor, circle(axis, 2 * detail.segments(40, 14), 1.5), detail, kMarbleTile));
  return plan;
}

MeshPlan roseFrame(const Detail& detail) {
  MeshPlan plan{"rose window", {}, {}, {}};
  const double r = kRoseRadius;
  Profile p(r + 0.2, -0.01);
  p.line(r + 0.2, 0.06).arc(r + 0.12, 0.08, 0.9, 2).line(r + 0.08, 0.06).arc(r + 0.02, 0.03, -0.9, 2).line(r, 0.02);
  p.line(r - 0.04, -0.25);
  plan.add(sweep(p, roundPath(kFace, kRoseHeight, r, detail.segments(36, 16)), detail, kPlasterTile));
  const auto ring = [&](double radius, double width) {
    Profile q(radius + width, -0.24);
    q.line(radius + width, -0.15).arc(radius - width, -0.15, 2, 2).line(radius - width, -0.24);
    plan.add(sweep(q, roundPath(kFace, kRoseHeight, radius, detail.segments(24, 12)), detail, kPlasterTile));
  };
  ring(0.42, 0.05);
  const int petals = detail.scale < 0.3 ? 6 : 12;
  for (int i = 0; i < petals; ++i) {
    const dvec2 cs = onCircle(double(i) / petals), between = onCircle((i + 0.5) / petals);
    const dvec3 center(0, kRoseHeight, -0.17), out(cs.x, cs.y, 0);
    plan.add(rod(center + 0.4 * out, center + (r - 0.03) * out, 0.03, detail.segments(6, 4), kPlasterTile));
    const dvec3 eye = center + dvec3(between.x, between.y, 0) * (r - 0.3);
    const auto small = [eye](double v) {
      const dvec2 c = onCircle(v);
      return TubePoint{eye + dvec3(c.x, c.y, 0) * 0.235, {-c.y, c.x, 0}, {0, 0, 1}, 0.025, 0.03};
    };
    plan.add(tube(small, detail.segments(5, 3), detail.segments(14, 8), true, false,
                  dvec2(kTau * 0.028, kTau * 0.235) / kPlasterTile));
  }
  return plan;
}

MeshPlan roseGlass(const Detail& detail) {
  MeshPlan plan{"rose glass", {}, {}, {}};
  const Plane plane{{0, 0, -0.21}, {1, 0, 0}, {0, 1, 0}};
  for (const double half : {1.0, -1.0}) {
    const Plane turned{plane.origin, plane.s * half, plane.y * half};
    std::vector<Patch> pane = roundHeadedPane(turned, half * kRoseHeight, half * kRoseHeight, kRoseRadius + 0.06,
                                              {detail.segments(16, 8), 1, 1}, kRoseRadius);
    plan.add(std::move(pane.front()));  // only the half disc
  }
  return plan;
}

// Two bronze leaves with sunk panels and bosses.
MeshPlan door(const Detail& detail) {
  MeshPlan plan{"door", {}, shadeInHall(kEast), {}};
  const double r = kDoorRadius + 0.01;
  plan.add(quad({-r, -0.002, 0.05}, {r, -0.002, 0.05}, {r, -0.002, -0.36}, {-r, -0.002, -0.36}, 1, 1));  // the sill
  const Plane plane{{0, 0, -0.3}, {1, 0, 0}, {0, 1, 0}};
  plan.add(roundHeadedPane(plane, 0, kDoorSpring, kDoorRadius + 0.09, {detail.segments(14, 6), 1, 1}, 1));
  Profile panel(0, 0);
  panel.line(0, 0.04).arc(-0.06, 0.06, 1.2, 2).line(-0.08, 0.03).line(-0.355, 0.03);
  for (int column = -1; column <= 1; column += 2) {
    for (int row = 0; row < 4; ++row) {
      const double x = column * 0.72, y = 0.52 + row * 0.86;
      const std::vector<dvec2> corners{{0.6, 0.36}, {0.6, -0.36}, {-0.6, -0.36}, {-0.6, 0.36}};
      // sweepPolygon() builds the panel flat; this transform sets it upright, so that +Y becomes the wall's front.
      glm::dmat4 upright(1);
      upright[1] = {0, 0, 1, 0};
      upright[2] = {0, -1, 0, 0};
      upright[3] = {x, y, -0.3, 1};
      plan.add(transformed(sweepPolygon(panel, corners, true, 1, detail), upright));
      Profile boss(0.13, 0.02);
      boss.arc(0, 0.12, 1, 3);
      Path round = circle({{x, y, -0.3}, {0, 0, 1}, {1, 0, 0}}, detail.segments(10, 6), 0.1);
      plan.add(sweep(boss, round, detail));
    }
  }
  plan.add(wallPanel({{0, 0, -0.25}, {1, 0, 0}, {0, 1, 0}}, -0.04, 0.04, 0, kDoorSpring + kDoorRadius, 1, 1, 1));
  return plan;
}

struct Item {
  const char* name;
  MeshPlan plan;
  HallMaterial material;
};

void placeAll(HallBuilder& hall, uint32_t group, std::vector<Item> items) {
  for (Item& item : items) hall.place(item.name, group, hall.mesh(std::move(item.plan)), item.material);
}

}  // namespace

void addEnds(HallBuilder& hall) {
  const Detail& d = hall.detail;
  const uint32_t east = hall.group("apse", SceneBuilder::kRoot, at(0, 0, -kHalfLength));
  const uint32_t west = hall.group("entrance", SceneBuilder::kRoot, rotatedAt(0, 0, kHalfLength, 2));
  placeAll(hall, east,
           {{"wall", endWall(d, "apse end wall", kApseSpring, kApseRadius), HallMaterial::Ashlar},
            {"arch", portal(d, "apse arch", 0, kApseSpring, kApseRadius, 0.05), HallMaterial::Trim},
            {"arch bead", archBead(d), HallMaterial::Gilt},
            {"mosaic", semidome(d), HallMaterial::Mosaic},
            {"cornice", apseCornice(d), HallMaterial::Trim},
            {"slabs", apseWall(d, "apse slabs", kApseSpring - 0.47, 1.7, kMarbleTile), HallMaterial::RedMarble},
            {"dado", apseWall(d, "apse dado", 1.7, kApseFloor, kMarbleTile), HallMaterial::GreenMarble},
            {"pilasters", apsePilasters(d), HallMaterial::Marble},
            {"responds", apseResponds(d), HallMaterial::Trim},
            {"steps", steps(d), HallMaterial::Marble}});
  placeAll(hall, west,
           {{"wall", endWall(d, "entrance end wall", kDoorSpring, kDoorRadius), HallMaterial::Ashlar},
            {"portal", portal(d, "portal", 0, kDoorSpring, kDoorRadius, 0.35), HallMaterial::Trim},
            {"door", door(d), HallMaterial::Bronze}});
  const uint32_t cornice = hall.mesh(endCornice(d)), frame = hall.mesh(roseFrame(d)), glass = hall.mesh(roseGlass(d));
  for (const uint32_t group : {east, west}) {
    hall.place("cornice", group, cornice, HallMaterial::Trim);
    hall.place("rose", group, frame, HallMaterial::Trim);
    hall.place("rose glass", group, glass, HallMaterial::WindowGlass);
  }
}

}  // namespace latelight::scene::builtin::hall
