// The nave's barrel vault: nine rows of painted coffers with gilded rosettes between ribs.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/wall.h"

namespace latelight::scene::builtin::hall {
namespace {

constexpr int kAround = 9, kAlong = 3;  // coffers across a half circle, and along a bay
constexpr double kTurn = 0.5 / kAround;
constexpr double kRibHalf = 0.3, kBarHalf = 0.11;
constexpr double kPitch = (kBay - 2 * kRibHalf) / kAlong;
constexpr double kHalfAround = kVaultRadius * kTurn * kPi - kBarHalf + 0.02;  // half a coffer's opening between its
                                                                              // bars
constexpr double kHalfAlong = kPitch / 2 - kBarHalf + 0.02;
constexpr double kDepth = 0.21;  // depth of the coffer's ground behind the vault's surface

// Maps coordinates on the vault's surface to space, with the vault's axis along Z through the origin: `p` meters around
// from the crown, `q` along the axis, `d` outwards behind the surface.
dvec3 bent(double p, double q, double d) {
  const dvec2 cs = onCircle(p / (kTau * kVaultRadius));
  return {(kVaultRadius + d) * cs.y, (kVaultRadius + d) * cs.x, q};
}

// A molding around the inside of a coffer; the profile's x is measured inwards from the opening's edge, its y outwards
// behind the surface.
std::vector<Patch> frame(const Profile& profile, const Detail& detail) {
  const dvec2 corners[] = {
      {kHalfAround, -kHalfAlong}, {kHalfAround, kHalfAlong}, {-kHalfAround, kHalfAlong}, {-kHalfAround, -kHalfAlong}};
  std::vector<Patch> patches;
  for (const Profile::Run& run : profile.sample(detail)) {
    for (int side = 0; side < 4; ++side) {
      const dvec2 a = corners[side], b = corners[(side + 1) % 4];
      Patch patch;
      patch.columns = detail.segments(2);
      patch.rows = static_cast<uint32_t>(run.size() - 1);
      const auto shrunk = [](dvec2 corner, double by) { return corner - glm::sign(corner) * by; };
      const auto flat = [=, rows = patch.rows](double u, double v) {
        const double at = v * rows;
        const size_t i = std::min<size_t>(rows - 1, static_cast<size_t>(at));
        const dvec2 p = run[i].position + (run[i + 1].position - run[i].position) * (at - double(i));
        const dvec2 from = shrunk(a, p.x), to = shrunk(b, p.x);
        return dvec3(u >= 1 ? to : from + (to - from) * u, p.y);
      };
      patch.surface = surfaceOf(
          [=](double u, double v) {
            const dvec3 p = flat(u, v);
            return bent(p.x, p.y, p.z);
          },
          [=, rows = patch.rows](double u, double v) {
            const dvec3 p = flat(u, v);
            const double at = v * rows;
            const size_t i = std::min<size_t>(rows - 1, static_cast<size_t>(at));
            const double length = run[i].length + (run[i + 1].length - run[i].length) * (at - double(i));
            return dvec2(glm::dot(dvec2(p) - a, glm::normalize(b - a)), -length) / kPlasterTile;
          });
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

// The occlusion from a coffer's depth, computed from the distance behind the surface.
Shade coffersShade() {
  return [](vec3 p, vec3) {
    const float d = std::sqrt(p.x * p.x + p.y * p.y) - float(kVaultRadius);
    return 1 - 0.45f * std::clamp(d / float(kDepth), 0.0f, 1.0f);
  };
}

MeshPlan cofferFrame(const Detail& detail) {
  MeshPlan plan{"coffer", {}, coffersShade(), {}};
  Profile p(0, 0.03);  // behind the bars' faces even where a chord of the arc sags
  p.line(0.01, 0.06).line(0.075, 0.065).line(0.08, 0.13).arc(0.13, 0.17, -1, 2).line(0.2, 0.17);
  p.line(0.2, kDepth + 0.01);
  plan.add(frame(p, detail));
  return plan;
}

MeshPlan cofferBead(const Detail& detail) {
  MeshPlan plan{"coffer bead", {}, coffersShade(), {}};
  if (detail.scale < 0.3) return plan;
  Profile p(0.18, 0.2);
  p.line(0.18, 0.17).arc(0.225, 0.17, -2, 2).line(0.225, kDepth + 0.01);
  plan.add(frame(p, detail));
  return plan;
}

MeshPlan cofferGround(const Detail& detail) {
  MeshPlan plan{"coffer ground", {}, {}, {}};
  const double p = kHalfAround - 0.16, q = kHalfAlong - 0.16;
  Patch patch;
  patch.columns = patch.rows = detail.segments(3, 1);
  const auto flat = [=](double u, double v) { return dvec2(p * (2 * u - 1), q * (2 * v - 1)); };
  patch.surface = surfaceOf(
      [=](double u, double v) {
        const dvec2 at = flat(u, v);
        return bent(at.x, at.y, kDepth);
      },
      [=](double u, double v) { return flat(u, v) * dvec2(1, -1) / kPlasterTile; });
  plan.add(std::move(patch));
  const float edgeP = float(p), edgeQ = float(q);
  plan.shade = [=](vec3 at, vec3) {
    const float a = edgeP - std::abs(at.x), b = edgeQ - std::abs(at.z);
    return 0.5f + 0.5f * std::clamp(std::min(a, b) / 0.16f, 0.0f, 1.0f);
  };
  return plan;
}

// Eight petals around a boss, on the ground of a coffer.
MeshPlan rosette(const Detail& detail) {
  MeshPlan plan{"rosette", {}, {}, {}};
  if (detail.scale < 0.2) return plan;
  Patch patch;
  patch.columns = 8 * detail.segments(2.5, 2);
  patch.rows = detail.segments(5, 2);
  patch.closedU = true;
  patch.pointV1 = true;
  patch.averaged = true;
  const auto position = [](double u, double v) {
    const double petal = std::sqrt(std::abs(sinQuarters(16 * u)));
    const double r = 1 - v, bulge = sinQuarters(2 * std::min(1.0, r * 1.02 + 0.0));
    const double boss = std::max(0.0, 1 - r * r / 0.07);
    const double radius = 0.24 * r * (1 - (1 - petal) * 0.3 * r);
    const double height = (0.02 + 0.065 * petal) * bulge + 0.075 * boss * (2 - boss) - 0.01 * r;
    const dvec2 cs = onCircle(u);
    return dvec3(radius * cs.x, kVaultRadius + kDepth - height, radius * cs.y);
  };
  patch.surface = surfaceOf(position, [](double u, double v) { return dvec2(u, -v); });
  plan.add(std::move(patch));
  plan.shade = [](vec3 p, vec3) {
    const float height = float(kVaultRadius + kDepth) - p.y;
    return 0.45f + 0.55f * std::clamp(height / 0.06f, 0.0f, 1.0f);
  };
  return plan;
}

// The grid between the coffers of a bay, and the rib to the next bay.
MeshPlan bars(const Detail& detail) {
  MeshPlan plan{"vault bars", {}, {}, {}};
  Profile along(-0.06, -kBarHalf);
  along.line(0.03, -kBarHalf).arc(0.05, -kBarHalf + 0.02, -0.9, 1).line(0.05, kBarHalf - 0.02);
  along.arc(0.03, kBarHalf, -0.9, 1).line(-0.06, kBarHalf);
  const double z = kBay / 2;
  for (int i = 0; i <= kAround; ++i) {
    const dvec2 cs = onCircle((i - kAround * 0.5) * kTurn);
    const dvec3 radial(cs.y, cs.x, 0), around(cs.x, -cs.y, 0);
    const Path path = straight(radial * kVaultRadius + dvec3(0, 0, z), radial * kVaultRadius - dvec3(0, 0, z), -radial,
                               around, detail.segments(2));
    plan.add(sweep(along, path, detail, kPlasterTile));
  }
  // Vertices at the crossings with the bars above, so that chords don't sink into them.
  const uint32_t segments = 2 * kAround * detail.segments(1.5);
  const double r = kVaultRadius;
  for (int i = 1; i < kAlong; ++i) {
    Profile across(r + 0.06, kBarHalf);
    across.line(r - 0.04, kBarHalf).line(r - 0.06, kBarHalf - 0.02).line(r - 0.06, -kBarHalf + 0.02);
    across.line(r - 0.04, -kBarHalf).line(r + 0.06, -kBarHalf);
    const Plane plane{{0, 0, (i - kAlong * 0.5) * kPitch}, {1, 0, 0}, {0, 1, 0}};
    plan.add(sweep(across, archPath(plane, 0, r, segments), detail, kPlasterTile));
  }
  // A shell behind the coffers, so that the sky is not visible through the joints between them.
  Profile shell(r + 0.3, z);
  shell.line(r + 0.3, -z);
  plan.add(sweep(shell, archPath({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0, r, segments / 2), detail, kPlasterTile));
  return plan;
}

MeshPlan rib(const Detail& detail) {
  MeshPlan plan{"vault rib", {}, {}, {}};
  const double r = kVaultRadius, h = kRibHalf + kBarHalf;  // overlaps the coffers' edges as far as the bars do
  Profile p(r + 0.06, h);
  p.line(r - 0.06, h).arc(r - 0.09, h - 0.03, -1, 2).line(r - 0.1, h - 0.06).line(r - 0.14, h - 0.065);
  p.line(r - 0.14, h - 0.1).line(r - 0.11, h - 0.115).line(r - 0.11, -h + 0.115).line(r - 0.14, -h + 0.1);
  p.line(r - 0.14, -h + 0.065).line(r - 0.1, -h + 0.06).line(r - 0.09, -h + 0.03).arc(r - 0.06, -h, -1, 2);
  p.line(r + 0.06, -h);
  const uint32_t segments = 2 * kAround * detail.segments(1.5);
  plan.add(sweep(p, archPath({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0, r, segments), detail, kPlasterTile));
  return plan;
}

// A rotation about the vault's axis.
mat4 turnedAround(double turn, double z) {
  const dvec2 cs = onCircle(turn);
  mat4 m(1);
  m[0] = vec4(cs.x, -cs.y, 0, 0);
  m[1] = vec4(cs.y, cs.x, 0, 0);
  m[3] = vec4(0, kVaultSpring, z, 1);
  return m;
}

}  // namespace

void addVault(HallBuilder& hall) {
  const Detail& d = hall.detail;
  const uint32_t frame = hall.mesh(cofferFrame(d)), bead = hall.mesh(cofferBead(d)),
                 ground = hall.mesh(cofferGround(d));
  const uint32_t flower = hall.mesh(rosette(d)), grid = hall.mesh(bars(d)), ribs = hall.mesh(rib(d));
  const uint32_t vault = hall.group("vault", SceneBuilder::kRoot);
  for (int bay = kBays - 1; bay >= 0; --bay) {
    const uint32_t group = hall.group(fmt::format("bay {}", kBays - bay), vault);
    const double z = bayCenter(bay);
    hall.place("bars", group, grid, HallMaterial::Trim, at(0, kVaultSpring, z));
    for (int i = 0; i < kAround; ++i) {
      for (int j = 0; j < kAlong; ++j) {
        const mat4 where = turnedAround((i - (kAround - 1) * 0.5) * kTurn, z + (j - (kAlong - 1) * 0.5) * kPitch);
        const std::string number = std::to_string(i * kAlong + j + 1);
        hall.place("coffer " + number, group, frame, HallMaterial::Trim, where);
        hall.place("bead " + number, group, bead, HallMaterial::Gilt, where);
        hall.place("ground " + number, group, ground, HallMaterial::VaultBlue, where);
        hall.place("rosette " + number, group, flower, HallMaterial::Gilt, where);
      }
    }
  }
  for (int boundary = kBays; boundary >= 0; --boundary)
    hall.place(fmt::format("rib {}", kBays - boundary + 1), vault, ribs, HallMaterial::Trim,
               at(0, kVaultSpring, bayBoundary(boundary)));
}

}  // namespace latelight::scene::builtin::hall
