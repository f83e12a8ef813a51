// The galleries above the aisles: three small arches per bay on slender columns, behind a balustrade.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/tube.h"
#include "scene/builtin/wall.h"

namespace latelight::scene::builtin::hall {
namespace {

// One bay at x = 0, as in arcades.cpp.
constexpr double kRailLow = 8.64, kPlinthHigh = 8.0;
constexpr double kPierHalf = kGalleryPitch / 2 - kGalleryArchRadius;

std::vector<dvec2> rectangle(double x, double z) {
  return {{x, z}, {x, -z}, {-x, -z}, {-x, z}};
}

MeshPlan arcadeWall(const Detail& detail) {
  MeshPlan plan{"gallery wall", {}, shadeInHall(kBayOnTheRight), {}};
  const WallGrid grid{detail.segments(10, 5), detail.segments(1.5, 1), 1};
  for (int arch = -1; arch <= 1; ++arch) {
    const double z = arch * kGalleryPitch;
    for (const double face : {-1.0, 1.0}) {
      const Plane plane{{face * kWallHalf, 0, z}, {0, 0, -face}, {0, 1, 0}};
      plan.add(wallAboveArch(plane, kGalleryPitch / 2, kGallerySpring, kGalleryArchRadius + 0.07, kGalleryTop + 0.1,
                             grid, kPlasterTile));
    }
  }
  return plan;
}

MeshPlan archivolts(const Detail& detail) {
  MeshPlan plan{"gallery archivolts", {}, shadeInHall(kBayOnTheRight), {}};
  const double r = kGalleryArchRadius, t = kWallHalf;
  Profile profile(r + 0.14, t - 0.01);
  profile.line(r + 0.14, t + 0.035).line(r + 0.09, t + 0.04).line(r + 0.085, t + 0.02).line(r, t + 0.015);
  profile.line(r, -t - 0.015).line(r + 0.085, -t - 0.02).line(r + 0.09, -t - 0.04).line(r + 0.14, -t - 0.035);
  profile.line(r + 0.14, -t + 0.01);
  for (int arch = -1; arch <= 1; ++arch) {
    const Plane plane{{0, 0, arch * kGalleryPitch}, {0, 0, 1}, {0, 1, 0}};
    plan.add(sweep(profile, archPath(plane, kGallerySpring, r, detail.segments(14, 6)), detail, kPlasterTile));
  }
  return plan;
}

MeshPlan column(const Detail& detail) {
  MeshPlan plan{"gallery column", {}, {}, {}};
  const double low = kBalustradeTop, high = kGallerySpring;
  Profile p(0.15, low);
  p.line(0.15, low + 0.04).line(0.125, low + 0.04).arc(0.125, low + 0.11, 2, 2).line(0.105, low + 0.12);
  p.arc(0.095, low + 0.16, -0.8, 1.5).smooth().curve({{0.094, low + 0.6}, {0.082, high - 0.3}}, 1.5);
  p.line(0.1, high - 0.295).line(0.1, high - 0.265).line(0.082, high - 0.26).arc(0.15, high - 0.07, -0.8, 3);
  plan.add(sweep(p, circle(Axis{}, detail.segments(12, 5), 0.1), detail, kMarbleTile));
  return plan;
}

MeshPlan abacus(const Detail& detail) {
  MeshPlan plan{"gallery abacus", {}, {}, {}};
  Profile p(-0.15, kGallerySpring - 0.075);
  p.line(-0.02, kGallerySpring - 0.075).arc(0, kGallerySpring - 0.04, 0.9, 2).line(0, kGallerySpring);
  p.line(-0.15, kGallerySpring);
  plan.add(sweepPolygon(p, rectangle(0.2, kPierHalf), true, 1, detail, kPlasterTile));
  // A lintel carries the wall, which is thicker than the column.
  Profile lintel(-0.15, kGallerySpring - 0.005);
  lintel.line(0.05, kGallerySpring - 0.005).line(0.05, kGallerySpring + 0.06).line(-0.1, kGallerySpring + 0.1);
  plan.add(sweepPolygon(lintel, rectangle(kWallHalf, kPierHalf), true, 1, detail, kPlasterTile));
  return plan;
}

MeshPlan pedestal(const Detail& detail) {
  MeshPlan plan{"balustrade pedestal", {}, shadeInHall(kBayOnTheRight + vec3(0, 0, float(kGalleryPitch / 2))), {}};
  Profile p(0.025, kGalleryFloor - 0.02);
  p.line(0.025, kPlinthHigh)
      .arc(0, kPlinthHigh + 0.03, -1, 2)
      .line(0, kRailLow - 0.02)
      .arc(0.03, kRailLow + 0.03, -1, 2);
  p.line(0.035, kRailLow + 0.035).line(0.035, kBalustradeTop).line(-0.12, kBalustradeTop);
  plan.add(sweepPolygon(p, rectangle(0.18, 0.17), true, 1, detail, kPlasterTile));
  return plan;
}

// A pier between two bays, up to the arches, in place of a column.
MeshPlan pier(const Detail& detail) {
  MeshPlan plan{"gallery pier", {}, shadeInHall(kBayOnTheRight + vec3(0, 0, float(kBay / 2))), {}};
  Profile p(0.03, kGalleryFloor - 0.02);
  p.line(0.03, kGalleryFloor + 0.15).line(0, kGalleryFloor + 0.18).line(0, kGallerySpring - 0.15);
  p.segments(3, 1).arc(0.04, kGallerySpring - 0.06, -1, 2).line(0.045, kGallerySpring - 0.05);
  p.line(0.045, kGallerySpring + 0.01).line(-0.1, kGallerySpring + 0.01);
  plan.add(sweepPolygon(p, rectangle(kWallHalf, kPierHalf), true, detail.segments(1), detail, kPlasterTile));
  return plan;
}

MeshPlan rails(const Detail& detail) {
  MeshPlan plan{"balustrade rails", {}, shadeInHall(kBayOnTheRight), {}};
  Profile top(-0.02, kRailLow);
  top.line(0.07, kRailLow).line(0.07, kRailLow + 0.03).arc(0.115, kRailLow + 0.08, 1, 2).line(0.125, kRailLow + 0.085);
  top.line(0.125, kBalustradeTop - 0.02).line(0.11, kBalustradeTop).line(-0.02, kBalustradeTop);
  Profile bottom(0.1, kGalleryFloor - 0.02);
  bottom.line(0.1, kPlinthHigh - 0.03).line(0.07, kPlinthHigh).line(-0.02, kPlinthHigh);
  const double z = kBay / 2;
  for (const Profile& profile : {top, bottom}) {
    const uint32_t along = detail.segments(2, 1);
    plan.add(sweep(profile, straight({0, 0, -z}, {0, 0, z}, {-1, 0, 0}, {0, 1, 0}, along), detail, kPlasterTile));
    plan.add(sweep(profile, straight({0, 0, z}, {0, 0, -z}, {1, 0, 0}, {0, 1, 0}, along), detail, kPlasterTile));
  }
  return plan;
}

MeshPlan baluster(const Detail& detail) {
  MeshPlan plan{"baluster", {}, {}, {}};
  if (detail.scale < 0.2) {  // a plain post
    plan.add(rod({0, kPlinthHigh - 0.01, 0}, {0, kRailLow + 0.01, 0}, 0.045, 4));
    return plan;
  }
  Profile p(0.05, kPlinthHigh - 0.005);
  p.line(0.05, 8.04).line(0.03, 8.05).smooth().curve({{0.06, 8.17}, {0.045, 8.3}, {0.024, 8.44}, {0.026, 8.52}}, 1.6);
  p.line(0.042, 8.53).arc(0.042, 8.57, 2, 1.5).line(0.045, 8.6).line(0.045, kRailLow + 0.005);
  plan.add(sweep(p, circle(Axis{}, detail.segments(9, 4), 0.05), detail, kMarbleTile));
  return plan;
}

struct Meshes {
  uint32_t wall, archivolts, column, abacus, pedestal, pier, rails, baluster;
};

void placeBay(HallBuilder& hall, const Meshes& m, uint32_t group) {
  constexpr int kBalusters = 4;
  hall.place("wall", group, m.wall, HallMaterial::Plaster);
  hall.place("archivolts", group, m.archivolts, HallMaterial::Trim);
  hall.place("rails", group, m.rails, HallMaterial::Trim);
  int number = 0;
  for (int arch = -1; arch <= 1; ++arch) {
    for (int i = 0; i < kBalusters; ++i) {
      const double z = arch * kGalleryPitch + (i - (kBalusters - 1) * 0.5) * 0.28125;
      hall.place(fmt::format("baluster {}", ++number), group, m.baluster, HallMaterial::Marble, at(0, 0, z));
    }
  }
  for (int i = 0; i < 2; ++i) {
    const mat4 where = at(0, 0, (i - 0.5) * kGalleryPitch);
    hall.place(fmt::format("pedestal {}", i + 1), group, m.pedestal, HallMaterial::Trim, where);
    hall.place(fmt::format("column {}", i + 1), group, m.column, HallMaterial::Marble, where);
    hall.place(fmt::format("abacus {}", i + 1), group, m.abacus, HallMaterial::Trim, where);
  }
}

}  // namespace

void addGalleries(HallBuilder& hall) {
  const Detail& d = hall.detail;
  const Meshes meshes{hall.mesh(arcadeWall(d)), hall.mesh(archivolts(d)), hall.mesh(column(d)), hall.mesh(abacus(d)),
                      hall.mesh(pedestal(d)),   hall.mesh(pier(d)),       hall.mesh(rails(d)),  hall.mesh(baluster(d))};
  for (int side = 0; side < 2; ++side) {
    const double x = side ? -kColumnX : kColumnX;
    const uint32_t gallery = hall.group(side ? "left gallery" : "right gallery", SceneBuilder::kRoot);
    for (int bay = kBays - 1; bay >= 0; --bay)
      placeBay(hall, meshes,
               hall.group(fmt::format("bay {}", kBays - bay), gallery, rotatedAt(x, 0, bayCenter(bay), 2 * side)));
    for (int boundary = kBays; boundary >= 0; --boundary)
      hall.place(fmt::format("pier {}", kBays - boundary + 1), gallery, meshes.pier, HallMaterial::Trim,
                 rotatedAt(x, 0, bayBoundary(boundary), 2 * side));
  }
}

}  // namespace latelight::scene::builtin::hall
