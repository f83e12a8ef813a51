// The arcade between nave and aisle: arches, the wall above them with its roundels, cornices, and pilaster strips.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/wall.h"

namespace latelight::scene::builtin::hall {
namespace {

// One bay at x = 0, centered at z = 0; the nave is towards -X. Copies for the other side are rotated.
const Plane kNaveFace{{-kWallHalf, 0, 0}, {0, 0, 1}, {0, 1, 0}};
const Plane kAisleFace{{kWallHalf, 0, 0}, {0, 0, -1}, {0, 1, 0}};

MeshPlan spandrels(const Detail& detail) {
  MeshPlan plan{"spandrels", {}, shadeInHall(kBayOnTheRight), {}};
  const WallGrid grid{detail.segments(16, 8), detail.segments(4, 1), 1};
  for (const Plane& plane : {kNaveFace, kAisleFace})
    plan.add(wallAboveArch(plane, kBay / 2, kArchSpring, kArchRadius + 0.1, kArcadeTop + 0.1, grid, kPlasterTile));
  return plan;
}

// Three stepped fasciae on both faces and a recessed soffit.
MeshPlan archivolt(const Detail& detail) {
  MeshPlan plan{"archivolt", {}, shadeInHall(kBayOnTheRight), {}};
  const double r = kArchRadius, t = kWallHalf;
  Profile profile(r + 0.3, t - 0.02);
  profile.line(r + 0.3, t + 0.055)
      .arc(r + 0.25, t + 0.075, 1, 2)
      .line(r + 0.22, t + 0.075)
      .arc(r + 0.18, t + 0.045, -1, 2);
  profile.line(r + 0.09, t + 0.04).line(r + 0.085, t + 0.025).line(r + 0.01, t + 0.02).line(r, t + 0.01);
  profile.line(r, t - 0.07).line(r + 0.025, t - 0.085).line(r + 0.025, -t + 0.085).line(r, -t + 0.07);
  profile.line(r, -t - 0.01).line(r + 0.01, -t - 0.02).line(r + 0.085, -t - 0.025).line(r + 0.09, -t - 0.04);
  profile.line(r + 0.18, -t - 0.045).arc(r + 0.22, -t - 0.075, -1, 2).line(r + 0.25, -t - 0.075);
  profile.arc(r + 0.3, -t - 0.055, 1, 2).line(r + 0.3, -t + 0.02);
  // The path's front faces the nave, where the profile's y is positive.
  plan.add(sweep(profile, archPath({{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}, kArchSpring, r, detail.segments(22, 8)), detail,
                 kPlasterTile));
  return plan;
}

// A scrolled wedge at the arch's crown, on both faces.
MeshPlan keystone(const Detail& detail) {
  MeshPlan plan{"keystone", {}, {}, {}};
  Profile side(0, kArchSpring + kArchRadius + 0.03);
  side.line(kWallHalf + 0.07, kArchSpring + kArchRadius + 0.03)
      .arc(kWallHalf + 0.1, kArchSpring + kArchRadius + 0.08, 1.2, 3);
  side.smooth()
      .arc(kWallHalf + 0.17, kArchSpring + kArchRadius + 0.36, -0.8, 3)
      .line(kWallHalf + 0.17, kArchSpring + kArchRadius + 0.42);
  side.line(0, kArchSpring + kArchRadius + 0.42);
  const auto half = [](double y) { return 0.1 + 0.09 * (y - kArchSpring - kArchRadius); };
  for (const double sign : {-1.0, 1.0}) {
    for (Profile::Run& run : side.sample(detail)) {
      const uint32_t rows = static_cast<uint32_t>(run.size() - 1);
      Patch patch;
      patch.columns = 1;
      patch.rows = rows;
      patch.surface = [=](double u, double v) {
        const Profile::Point& p = run[static_cast<size_t>(v * rows + 0.5)];
        SurfacePoint point;
        point.position = {sign * p.position.x, p.position.y, sign * half(p.position.y) * (1 - 2 * u)};
        point.normal = {sign * p.normal.x, p.normal.y, 0};
        point.tangent = {0, 0, -sign};
        point.uv = {u * 0.1, -p.length / kPlasterTile};
        return point;
      };
      plan.add(std::move(patch));
    }
    // The wedge's sides, as strips from the wall's center plane to the face.
    for (const double cheek : {-1.0, 1.0}) {
      std::vector<dvec2> outline;
      const std::vector<Profile::Run> runs = side.sample(detail);
      for (size_t run = 1; run + 1 < runs.size(); ++run)  // the first and the last run are level and have no height
        for (size_t i = run == 1 ? 0 : 1; i < runs[run].size(); ++i) outline.push_back(runs[run][i].position);
      const uint32_t rows = static_cast<uint32_t>(outline.size() - 1);
      Patch patch;
      patch.columns = 1;
      patch.rows = rows;
      patch.surface = [=](double u, double v) {
        const dvec2 p = outline[static_cast<size_t>(v * rows + 0.5)];
        const double x = p.x * (sign == cheek ? u : 1 - u);  // so that the front faces outwards on every side
        SurfacePoint point;
        point.position = {sign * x, p.y, cheek * half(p.y)};
        point.normal = glm::normalize(dvec3(0, -0.09, cheek));
        point.tangent = {cheek, 0, 0};
        point.uv = dvec2(cheek * sign * x, -p.y) / kPlasterTile;
        return point;
      };
      plan.add(std::move(patch));
    }
  }
  return plan;
}

// A shallow strip over each column, up to the vault, which covers the joint between two bays.
MeshPlan strip(const Detail& detail) {
  MeshPlan plan{"pilaster strip", {}, shadeInHall({float(kColumnX), 0, float(kBay / 2)}), {}};
  const double front = -kWallHalf - 0.06;
  const uint32_t up = detail.segments(5, 1);
  const auto box = [&](double half, double low, double high) {
    plan.add(wallPanel({{front, 0, 0}, {0, 0, 1}, {0, 1, 0}}, -half, half, low, high, 1, up, kPlasterTile));
    plan.add(wallPanel({{0, 0, half}, {1, 0, 0}, {0, 1, 0}}, front, 0, low, high, 1, up, kPlasterTile));
    plan.add(wallPanel({{0, 0, -half}, {-1, 0, 0}, {0, 1, 0}}, 0, -front, low, high, 1, up, kPlasterTile));
  };
  box(0.15, kArchSpring, kArcadeTop + 0.1);
  box(0.15, kGalleryFloor, kGalleryTop + 0.1);
  return plan;
}

// A classical cornice: bed molding, corona with drip, cyma. `x` is measured outwards from the wall's face.
Profile cornice(double low, double high, double reach) {
  const double h = high - low;
  const auto y = [=](double t) { return low + t * h; };
  Profile p(-0.05, y(0));
  p.line(0.02, y(0)).line(0.02, y(0.14)).line(0.035, y(0.15)).arc(0.12 * reach + 0.035, y(0.3), -1, 3);
  p.line(0.2 * reach + 0.03, y(0.31)).line(0.2 * reach + 0.03, y(0.46)).line(0.72 * reach, y(0.47));
  p.line(0.72 * reach, y(0.64)).line(0.75 * reach, y(0.65)).arc(0.86 * reach, y(0.78), -0.9, 2);
  p.smooth().arc(0.98 * reach, y(0.92), 0.9, 2).line(reach, y(0.93)).line(reach, y(1)).line(-0.4, y(1));
  return p;
}

MeshPlan cornices(const Detail& detail) {
  MeshPlan plan{"cornices", {}, shadeInHall(kBayOnTheRight), {}};
  const double z = kBay / 2;
  const uint32_t along = detail.segments(2, 1);
  const auto nave = straight({-kWallHalf, 0, -z}, {-kWallHalf, 0, z}, {-1, 0, 0}, {0, 1, 0}, along);
  plan.add(sweep(cornice(kArcadeTop, kGalleryFloor, 0.3), nave, detail, kPlasterTile));
  plan.add(sweep(cornice(kGalleryTop, kVaultSpring, 0.42), nave, detail, kPlasterTile));
  // The architrave under the upper cornice, and the astragal along the arches' crowns.
  Profile fascia(-0.05, kGalleryTop - 0.16);
  fascia.line(0.03, kGalleryTop - 0.16).line(0.03, kGalleryTop - 0.08).line(0.045, kGalleryTop - 0.075);
  fascia.line(0.045, kGalleryTop);
  plan.add(sweep(fascia, nave, detail, kPlasterTile));
  return plan;
}

// Small blocks under the corona, as on a Corinthian entablature.
MeshPlan dentil(const Detail& detail) {
  MeshPlan plan{"dentils", {}, shadeInHall(kBayOnTheRight), {}};
  const double low = kGalleryTop + 0.335 * (kVaultSpring - kGalleryTop), high = low + 0.055;
  const double reach = -kWallHalf - 0.2, pitch = kBay / 18;
  if (detail.scale < 0.3) return plan;
  for (int i = 0; i < 18; ++i) {
    const double z = (i + 0.5) * pitch - kBay / 2, half = pitch * 0.28, back = -kWallHalf - 0.05;
    plan.add(wallPanel({{reach, 0, z}, {0, 0, 1}, {0, 1, 0}}, -half, half, low, high, 1, 1, kPlasterTile));
    plan.add(wallPanel({{0, 0, z + half}, {1, 0, 0}, {0, 1, 0}}, reach, back, low, high, 1, 1, kPlasterTile));
    plan.add(wallPanel({{0, 0, z - half}, {-1, 0, 0}, {0, 1, 0}}, -back, -reach, low, high, 1, 1, kPlasterTile));
    plan.add(quad({reach, low, z - half}, {back, low, z - half}, {back, low, z + half}, {reach, low, z + half}, 1, 1,
                  kPlasterTile));
  }
  return plan;
}

// A dished disc of colored marble in a molded ring, in each spandrel over a column.
MeshPlan roundel(const Detail& detail) {
  MeshPlan plan{"roundel", {}, {}, {}};
  Profile disc(0.2, 0);
  disc.arc(0, 0.045, 0.5, 3);
  // The profile of a surface of revolution runs from its rim inwards if the front faces up.
  plan.add(sweep(disc, circle({{0, 0, 0}, {-1, 0, 0}, {0, 0, 1}}, detail.segments(20, 6), 0.2), detail, kMarbleTile));
  return plan;
}

MeshPlan roundelRing(const Detail& detail) {
  MeshPlan plan{"roundel ring", {}, {}, {}};
  Profile ring(0.27, -0.08);
  ring.line(0.27, 0.02).arc(0.2, 0.02, 2, 2.5).line(0.2, -0.02);
  plan.add(sweep(ring, circle({{0, 0, 0}, {-1, 0, 0}, {0, 0, 1}}, detail.segments(22, 8), 0.25), detail));
  return plan;
}

}  // namespace

void addArcades(HallBuilder& hall) {
  const Detail& detail = hall.detail;
  const uint32_t spandrel = hall.mesh(spandrels(detail)), arch = hall.mesh(archivolt(detail));
  const uint32_t key = hall.mesh(keystone(detail)), moulding = hall.mesh(cornices(detail));
  const uint32_t blocks = hall.mesh(dentil(detail)), band = hall.mesh(strip(detail));
  const uint32_t disc = hall.mesh(roundel(detail)), ring = hall.mesh(roundelRing(detail));
  for (int side = 0; side < 2; ++side) {
    const double x = side ? -kColumnX : kColumnX;
    const uint32_t arcade = hall.group(side ? "left arcade" : "right arcade", SceneBuilder::kRoot);
    for (int bay = kBays - 1; bay >= 0; --bay) {
      const uint32_t group =
          hall.group(fmt::format("bay {}", kBays - bay), arcade, rotatedAt(x, 0, bayCenter(bay), 2 * side));
      hall.place("spandrels", group, spandrel, HallMaterial::Plaster);
      hall.place("archivolt", group, arch, HallMaterial::Trim);
      hall.place("keystone", group, key, HallMaterial::Trim);
      hall.place("cornices", group, moulding, HallMaterial::Trim);
      hall.place("dentils", group, blocks, HallMaterial::Trim);
    }
    for (int boundary = kBays; boundary >= 0; --boundary) {
      const std::string number = std::to_string(kBays - boundary + 1);
      const mat4 where = rotatedAt(x, 0, bayBoundary(boundary), 2 * side);
      hall.place("strip " + number, arcade, band, HallMaterial::Trim, where);
      if (boundary == 0 || boundary == kBays) continue;
      const mat4 high = where * at(-kWallHalf - 0.06, 6.35, 0);
      hall.place("roundel " + number, arcade, disc, boundary % 2 ? HallMaterial::RedMarble : HallMaterial::GreenMarble,
                 high);
      hall.place("roundel ring " + number, arcade, ring, HallMaterial::Gilt, high);
    }
  }
}

}  // namespace latelight::scene::builtin::hall
