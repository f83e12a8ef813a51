// The aisles: groin vaults with ribs, an outer wall with windows over a dado of glazed tiles, and the walls, floor and
// ceiling of the gallery above.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/wall.h"

namespace latelight::scene::builtin::hall {
namespace {

// One bay of the right aisle, with (0, 0, 0) at the center of its floor; the nave is towards -X.
const vec3 kAisleBay(float(kAisleX), 0, 0);
constexpr double kDado = 1.5;

// One cell of the groin vault, whose ceiling is the higher of two crossing barrels. The groins (the diagonals) and the
// bay's edges bound four cells, and only one barrel is visible within each.
Patch cell(const Detail& detail, bool alongZ, double sign) {
  Patch patch;
  patch.columns = 2 * detail.segments(5, 2);  // even, so that the groins' kink is at the center
  patch.rows = detail.segments(4, 2);
  patch.pointU0 = patch.pointU1 = true;
  const double across = alongZ ? kAisleHalf : kBay / 2, along = alongZ ? kBay / 2 : kAisleHalf;
  const auto position = [=](double u, double v) {
    const double turn = alongZ == (sign > 0) ? 2 * u - 1 : 1 - 2 * u;  // the front faces down in all four cells
    const double s = sinQuarters(turn), c = cosQuarters(turn);
    const double a = across * s, edge = std::abs(s);
    const double b = sign * along * (v >= 1 ? 1.0 : edge + v * (1 - edge));
    const double y = kArchSpring + kAisleRise * c;
    return alongZ ? dvec3(a, y, b) : dvec3(b, y, a);
  };
  patch.surface = surfaceOf(position, [=](double u, double v) {
    const dvec3 p = position(u, v);
    const double turn = 2 * u - 1, arc = turn * 0.5 * kPi * 2.05;  // nearly a circle of radius 2.05 m
    return dvec2(arc, -sign * (alongZ ? p.z : p.x)) / kPlasterTile;
  });
  return patch;
}

MeshPlan groinVault(const Detail& detail) {
  MeshPlan plan{"groin vault", {}, shadeInHall(kAisleBay), {}};
  for (const double sign : {-1.0, 1.0}) {
    plan.add(cell(detail, true, sign));
    plan.add(cell(detail, false, sign));
  }
  return plan;
}

// A rib along half an ellipse, from one corner over the bay's crown to the opposite corner.
Path ribPath(dvec3 half, uint32_t segments) {
  Path path;
  path.columns = segments;
  const double width = std::sqrt(half.x * half.x + half.z * half.z);
  const dvec3 across = dvec3(half.x, 0, half.z) / width;
  path.frame = [=](double u) {
    const dvec2 cs = onCircle(0.5 * u);
    const dvec3 origin = across * (width * cs.x) + dvec3(0, kArchSpring + half.y * cs.y, 0);
    const dvec3 outward = glm::normalize(across * (half.y * cs.x) + dvec3(0, width * cs.y, 0));
    const dvec3 y = glm::cross(across, dvec3(0, 1, 0));
    return PathFrame{origin, outward, y, 0.5 * u * kTau * (width + half.y) / 2};
  };
  return path;
}

// The rib's cross-section as seen from below; x is measured outwards from the rib's center line.
Profile ribProfile(double half, double depth) {
  Profile p(0.03, half);
  p.line(-0.3 * depth, half).arc(-0.75 * depth, 0.55 * half, -0.9, 2).line(-0.8 * depth, 0.5 * half);
  p.arc(-0.8 * depth, -0.5 * half, 1.6, 2).line(-0.75 * depth, -0.55 * half).arc(-0.3 * depth, -half, -0.9, 2);
  p.line(0.03, -half);
  return p;
}

MeshPlan diagonalRibs(const Detail& detail) {
  MeshPlan plan{"groin ribs", {}, {}, {}};
  const Profile profile = ribProfile(0.085, 0.15);
  for (const double sign : {-1.0, 1.0})
    plan.add(sweep(profile, ribPath({kAisleHalf, kAisleRise, sign * kBay / 2}, detail.segments(18, 6)), detail,
                   kPlasterTile));
  // The boss at the intersection of the ribs.
  Profile boss(0.0, -0.2);
  boss.arc(0.17, -0.1, 0.8, 3).line(0.2, -0.09).line(0.2, 0.02);
  Path path = circle({{0, kArchSpring + kAisleRise, 0}, {0, 1, 0}, {1, 0, 0}}, detail.segments(14, 6), 0.15);
  plan.add(sweep(boss, path, detail, kPlasterTile));
  return plan;
}

// The arch between two bays, from the column to the wall.
MeshPlan transverseArch(const Detail& detail) {
  MeshPlan plan{"transverse arch", {}, shadeInHall({float(kAisleX), 0, float(kBay / 2)}), {}};
  Profile p(0.03, 0.26);
  p.line(-0.12, 0.26).line(-0.125, 0.21).line(-0.15, 0.2).line(-0.15, -0.2).line(-0.125, -0.21).line(-0.12, -0.26);
  p.line(0.03, -0.26);
  plan.add(sweep(p, ribPath({kAisleHalf, kAisleRise, 0}, detail.segments(16, 6)), detail, kPlasterTile));
  return plan;
}

// A pilaster on the outer wall, opposite each column.
MeshPlan pilaster(const Detail& detail) {
  MeshPlan plan{"aisle pilaster", {}, shadeInHall({float(kOuterX), 0, float(kBay / 2)}), {}};
  Profile p(0.04, 0);
  p.line(0.04, 0.28).arc(0.01, 0.32, -1, 2).line(0, 0.33).line(0, 4.45).segments(4, 1).line(0.02, 4.46).line(0.02, 4.5);
  p.line(0, 4.51).line(0, 4.72).arc(0.06, 4.85, -1, 3).line(0.09, 4.86).line(0.09, 4.97).line(-0.1, 5);
  const std::vector<dvec2> corners{{0, -0.28}, {-0.15, -0.28}, {-0.15, 0.28}, {0, 0.28}};
  plan.add(sweepPolygon(p, corners, false, detail.segments(1), detail, kAshlarTile));
  return plan;
}

const Plane kOuterFace{{kAisleHalf, 0, 0}, {0, 0, 1}, {0, 1, 0}};

WallGrid wallGrid(const Detail& detail) {
  return {detail.segments(10, 6), detail.segments(3, 1), detail.segments(4, 1)};
}

MeshPlan outerWall(const Detail& detail) {
  MeshPlan plan{"outer wall", {}, shadeInHall(kAisleBay), {}};
  plan.add(wallWithWindow(kOuterFace, kBay / 2, kDado, 7.25, kWindowSill, kWindowSpring, kWindowRadius,
                          wallGrid(detail), kAshlarTile));
  return plan;
}

MeshPlan dado(const Detail& detail) {
  MeshPlan plan{"dado", {}, shadeInHall(kAisleBay), {}};
  const uint32_t along = detail.segments(6, 1), up = detail.segments(3, 1);
  plan.add(wallPanel(kOuterFace, -kBay / 2, kBay / 2, 0.2, kDado, along, up, kTileTile));
  return plan;
}

MeshPlan dadoMouldings(const Detail& detail) {
  MeshPlan plan{"dado mouldings", {}, shadeInHall(kAisleBay), {}};
  const double z = kBay / 2;
  const Path wall = straight({kAisleHalf, 0, -z}, {kAisleHalf, 0, z}, {-1, 0, 0}, {0, 1, 0}, detail.segments(2));
  Profile skirting(0.05, 0);
  skirting.line(0.05, 0.15).arc(0.02, 0.2, -1, 2).line(-0.02, 0.21);
  Profile rail(-0.02, kDado - 0.06);
  rail.line(0.02, kDado - 0.06).arc(0.05, kDado - 0.02, -1, 2).arc(0.05, kDado + 0.04, 2, 2).line(-0.02, kDado + 0.05);
  for (const Profile& profile : {skirting, rail}) plan.add(sweep(profile, wall, detail, kPlasterTile));
  return plan;
}

// The reveal of a window opening, a sill, and a molded frame around it.
MeshPlan windowFrame(const Detail& detail) {
  MeshPlan plan{"window frame", {}, {}, {}};
  const double r = kWindowRadius, depth = 0.32;
  Profile p(r + 0.16, -0.01);
  p.line(r + 0.16, 0.04).arc(r + 0.1, 0.06, 0.9, 2).line(r + 0.06, 0.06).line(r + 0.05, 0.03).line(r, 0.025);
  p.line(r, 0).line(r - 0.05, -depth);
  plan.add(sweep(p, archPath(kOuterFace, kWindowSpring, r, detail.segments(14, 4)), detail, kPlasterTile));
  // The jambs continue straight down from the arch's ends.
  const auto jamb = [&](double s) {
    const dvec3 foot = kOuterFace.origin + dvec3(0, kWindowSill, 0),
                head = kOuterFace.origin + dvec3(0, kWindowSpring, 0);
    return s > 0 ? straight(foot, head, {0, 0, 1}, {-1, 0, 0}, detail.segments(3))
                 : straight(head, foot, {0, 0, -1}, {-1, 0, 0}, detail.segments(3));
  };
  plan.add(sweep(p, jamb(1), detail, kPlasterTile));
  plan.add(sweep(p, jamb(-1), detail, kPlasterTile));
  Profile sill(-0.02, kWindowSill - 0.1);
  sill.line(0.09, kWindowSill - 0.1).line(0.09, kWindowSill - 0.04).line(0.1, kWindowSill - 0.03);
  sill.line(0.1, kWindowSill).line(-depth, kWindowSill + 0.06);
  const double half = r + 0.2;
  plan.add(sweep(sill,
                 straight({kAisleHalf, 0, -half}, {kAisleHalf, 0, half}, {-1, 0, 0}, {0, 1, 0}, detail.segments(2)),
                 detail, kPlasterTile));
  return plan;
}

MeshPlan windowPane(const Detail& detail) {
  MeshPlan plan{"window pane", {}, {}, {}};
  const Plane plane{{kAisleHalf + 0.28, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  plan.add(roundHeadedPane(plane, kWindowSill - 0.05, kWindowSpring, kWindowRadius + 0.03,
                           {detail.segments(12, 6), 1, 1}, 2 * kWindowRadius));
  return plan;
}

// The room above the vault: floor, back wall with a blind niche, and a ceiling.
MeshPlan galleryRoom(const Detail& detail) {
  MeshPlan plan{"gallery room", {}, shadeInHall(kAisleBay), {}};
  const double x0 = kColumnX - kAisleX - 0.2, x1 = kAisleHalf, z = kBay / 2;
  const uint32_t n = detail.segments(3, 1);
  plan.add(quad({x0, kGalleryTop, -z}, {x1, kGalleryTop, -z}, {x1, kGalleryTop, z}, {x0, kGalleryTop, z}, n, n,
                kPlasterTile));
  plan.add(wallPanel(kOuterFace, -z, z, kGalleryFloor - 0.1, kGalleryTop, detail.segments(5, 1), n, kPlasterTile));
  return plan;
}

MeshPlan galleryFloor(const Detail& detail) {
  MeshPlan plan{"gallery floor", {}, shadeInHall(kAisleBay), {}};
  const double x0 = kColumnX - kAisleX - 0.2, x1 = kAisleHalf, z = kBay / 2;
  const uint32_t n = detail.segments(3, 1);
  plan.add(quad({x0, kGalleryFloor - 0.005, z}, {x1, kGalleryFloor - 0.005, z}, {x1, kGalleryFloor - 0.005, -z},
                {x0, kGalleryFloor - 0.005, -z}, n, n, kBay / 2));
  return plan;
}

struct Item {
  const char* name;
  uint32_t mesh;
  HallMaterial material;
};

}  // namespace

void addAisles(HallBuilder& hall) {
  const Detail& d = hall.detail;
  const Item items[] = {{"vault", hall.mesh(groinVault(d)), HallMaterial::Plaster},
                        {"ribs", hall.mesh(diagonalRibs(d)), HallMaterial::Trim},
                        {"wall", hall.mesh(outerWall(d)), HallMaterial::Ashlar},
                        {"dado", hall.mesh(dado(d)), HallMaterial::Tile},
                        {"dado mouldings", hall.mesh(dadoMouldings(d)), HallMaterial::Marble},
                        {"window frame", hall.mesh(windowFrame(d)), HallMaterial::Trim},
                        {"window pane", hall.mesh(windowPane(d)), HallMaterial::WindowGlass},
                        {"gallery room", hall.mesh(galleryRoom(d)), HallMaterial::Plaster},
                        {"gallery floor", hall.mesh(galleryFloor(d)), HallMaterial::AisleFloor}};
  const uint32_t arch = hall.mesh(transverseArch(d)), pier = hall.mesh(pilaster(d));
  for (int side = 0; side < 2; ++side) {
    const double sign = side ? -1 : 1;
    const uint32_t aisle = hall.group(side ? "left aisle" : "right aisle", SceneBuilder::kRoot);
    for (int bay = kBays - 1; bay >= 0; --bay) {
      const uint32_t group =
          hall.group(fmt::format("bay {}", kBays - bay), aisle, rotatedAt(sign * kAisleX, 0, bayCenter(bay), 2 * side));
      for (const Item& item : items) hall.place(item.name, group, item.mesh, item.material);
    }
    for (int boundary = kBays; boundary >= 0; --boundary) {
      const std::string number = std::to_string(kBays - boundary + 1);
      const double z = bayBoundary(boundary);
      hall.place("arch " + number, aisle, arch, HallMaterial::Trim, rotatedAt(sign * kAisleX, 0, z, 2 * side));
      hall.place("pilaster " + number, aisle, pier, HallMaterial::Ashlar, rotatedAt(sign * kOuterX, 0, z, 2 * side));
    }
  }
}

}  // namespace latelight::scene::builtin::hall
