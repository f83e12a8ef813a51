// Hanging and standing lamps, each with the position of its light: chandeliers in the nave, lanterns under the arches,
// in the aisles and galleries, and candle stands in the apse. There are one hundred in total.
#include <fmt/format.h>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/profile.h"
#include "scene/builtin/tube.h"

namespace latelight::scene::builtin::hall {
namespace {

constexpr vec3 kCandle(1.0f, 0.89f, 0.76f), kLantern(1.0f, 0.81f, 0.60f), kGallery(1.0f, 0.74f, 0.50f);
constexpr double kWheel = 1.15;  // radius of a chandelier
constexpr double kWheelHeight = 8.3;
constexpr int kCandles = 6;
constexpr double kLanternHeight = 0.62;

Path round(const Detail& detail, double normal, uint32_t least) {
  return circle(Axis{}, detail.segments(normal, least), 0.2);
}

// A lantern that hangs from y = 0 of its own frame, with its light at the center of its glass.
MeshPlan lanternFrame(const Detail& detail) {
  MeshPlan plan{"lantern", {}, {}, {}};
  Profile cap(0.19, -0.18);
  cap.line(0.2, -0.165).curve({{0.12, -0.1}, {0.05, -0.06}, {0.03, -0.02}}, 1.5).line(0.03, 0.01).line(0, 0.02);
  Profile underCap(0, -0.18);
  underCap.line(0.19, -0.18);
  Profile dish(0, -kLanternHeight - 0.07);
  dish.arc(0.03, -kLanternHeight - 0.03, 1.5, 2).line(0.02, -kLanternHeight - 0.015);
  dish.curve({{0.1, -kLanternHeight + 0.03}, {0.13, -kLanternHeight + 0.06}}, 1.5).line(0.13, -kLanternHeight + 0.08);
  dish.line(0, -kLanternHeight + 0.085);
  for (const Profile& profile : {cap, underCap, dish}) plan.add(sweep(profile, round(detail, 14, 5), detail));
  const int ribs = detail.scale < 0.3 ? 3 : 6;
  for (int i = 0; i < ribs; ++i) {
    const auto curve = [](double v) {
      return dvec2(0.13 + 0.055 * v + 0.05 * sinQuarters(2 * v), -kLanternHeight + 0.07 + v * (kLanternHeight - 0.24));
    };
    plan.add(tube(radialCurve(double(i) / ribs, curve, [](double) { return dvec2(0.009, 0.009); }),
                  detail.segments(5, 3), detail.segments(6, 2), false, false));
  }
  return plan;
}

MeshPlan lanternGlass(const Detail& detail) {
  MeshPlan plan{"lantern glass", {}, {}, {}};
  Profile p(0, -kLanternHeight + 0.08);
  p.curve({{0.08, -kLanternHeight + 0.1}, {0.135, -0.4}, {0.12, -0.26}, {0.06, -0.185}, {0, -0.175}}, 1.6);
  plan.add(sweep(p, round(detail, 14, 5), detail));
  return plan;
}

// A chain from y = 0 up to `length`, with alternating perpendicular links.
MeshPlan chain(const Detail& detail, const char* name, double length) {
  MeshPlan plan{name, {}, {}, {}};
  plan.add(rod({0, -0.02, 0}, {0, length + 0.02, 0}, 0.012, detail.segments(5, 3)));
  const int beads = std::max(2, static_cast<int>(length / 0.45));
  for (int i = 0; i <= beads && detail.scale > 0.3; ++i) {
    const double y = length * i / beads;
    Profile bead(0.012, y - 0.035);
    bead.arc(0.012, y + 0.035, 1.6, 2);
    plan.add(sweep(bead, circle(Axis{}, detail.segments(6, 4), 0.03), detail));
  }
  return plan;
}

// A wheel in the plane y = 0 with a cup for each candle, three stays to a ring above, and a boss below.
MeshPlan wheel(const Detail& detail) {
  MeshPlan plan{"chandelier", {}, {}, {}};
  Profile rim(kWheel - 0.03, -0.05);
  rim.line(kWheel + 0.03, -0.05)
      .arc(kWheel + 0.03, 0.05, 1, 2)
      .line(kWheel - 0.03, 0.05)
      .arc(kWheel - 0.03, -0.05, 1, 2);
  plan.add(sweep(rim, circle(Axis{}, detail.segments(40, 12), kWheel), detail));
  Profile hub(0, -0.32);
  hub.arc(0, -0.2, 2, 2).line(0.03, -0.19).curve({{0.14, -0.08}, {0.15, 0.02}, {0.05, 0.16}, {0.04, 0.8}}, 1.6);
  hub.line(0.07, 0.82).arc(0, 0.92, 1.2, 2);
  plan.add(sweep(hub, circle(Axis{}, detail.segments(14, 6), 0.1), detail));
  for (int i = 0; i < kCandles; ++i) {
    const dvec2 cs = onCircle((i + 0.5) / kCandles);
    const auto spoke = [](double v) { return dvec2(0.1 + (kWheel - 0.12) * v, -0.12 * sinQuarters(2 * v)); };
    if (i % 2 == 0)
      plan.add(tube(radialCurve((i + 0.5) / kCandles, spoke, [](double) { return dvec2(0.014, 0.014); }),
                    detail.segments(5, 3), detail.segments(8, 4), false, false));
    const dvec3 foot(kWheel * cs.x, 0, -kWheel * cs.y);
    Profile cup(0, 0.03);
    cup.line(0.02, 0.04).line(0.025, 0.1).arc(0.075, 0.15, 0.8, 2).line(0.075, 0.165).line(0, 0.16);
    plan.add(sweep(cup, circle({foot, {0, 1, 0}, {1, 0, 0}}, detail.segments(9, 5), 0.06), detail));
    if (i % 2 == 0) plan.add(rod(foot, {0, 0.85, 0}, 0.008, detail.segments(4, 3)));
  }
  return plan;
}

// A glass globe around its light at y = 0.
MeshPlan globe(const Detail& detail) {
  MeshPlan plan{"globe", {}, {}, {}};
  Profile p(0, -0.075);
  p.arc(0, 0.075, 2).segments(8, 4);
  plan.add(sweep(p, circle(Axis{}, detail.segments(14, 6), 0.075), detail));
  return plan;
}

MeshPlan candleStand(const Detail& detail) {
  MeshPlan plan{"candle stand", {}, {}, {}};
  Profile p(0.2, 0);
  p.line(0.2, 0.02).arc(0.12, 0.07, -0.8, 2).line(0.04, 0.1).smooth();
  p.curve({{0.03, 0.25}, {0.05, 0.33}, {0.02, 0.42}, {0.022, 0.9}, {0.05, 0.98}, {0.02, 1.06}, {0.025, 1.45}}, 1.5);
  p.line(0.1, 1.5).line(0.1, 1.515).line(0.0, 1.515);
  plan.add(sweep(p, circle(Axis{}, detail.segments(12, 5), 0.06), detail));
  return plan;
}

struct Meshes {
  uint32_t frame, glass, wheel, globe, stand;
};

vec3 inWorld(const HallBuilder& hall, uint32_t group, vec3 p) {
  return vec3(hall.builder.scene.nodes[group].toWorld * vec4(p, 1));
}

// Adds a lantern whose top hangs from the frame `where`, on a chain up to a ceiling.
void addLantern(HallBuilder& hall, const Meshes& meshes, const std::string& name, uint32_t chainMesh, mat4 where,
                LampSite site) {
  const uint32_t group = hall.group(name, SceneBuilder::kRoot, where);
  hall.place("frame", group, meshes.frame, HallMaterial::Brass);
  hall.place("chain", group, chainMesh, HallMaterial::Brass);
  site.instance = hall.place("glass", group, meshes.glass, HallMaterial::DarkGlass);
  site.position = inWorld(hall, group, {0, -float(kLanternHeight) / 2 - 0.06f, 0});
  hall.lamp(site);
}

void addChandelier(HallBuilder& hall, const Meshes& meshes, int number, uint32_t chainMesh, double z) {
  const uint32_t group = hall.group(fmt::format("chandelier {}", number), SceneBuilder::kRoot, at(0, kWheelHeight, z));
  hall.place("wheel", group, meshes.wheel, HallMaterial::Brass);
  hall.place("chain", group, chainMesh, HallMaterial::Brass, at(0, 0.9, 0));
  for (int i = 0; i < kCandles; ++i) {
    const dvec2 cs = onCircle((i + 0.5) / kCandles);
    const vec3 where(float(kWheel * cs.x), 0.24f, float(-kWheel * cs.y));
    LampSite site{{}, kCandle, 1.7f, 14.0f, kNoInstance};
    site.instance = hall.place(fmt::format("globe {}", i + 1), group, meshes.globe, HallMaterial::DarkGlass,
                               at(where.x, where.y, where.z));
    site.position = inWorld(hall, group, where);
    hall.lamp(site);
  }
}

void addCandleStand(HallBuilder& hall, const Meshes& meshes, const std::string& name, mat4 where, LampSite site) {
  const uint32_t group = hall.group(name, SceneBuilder::kRoot, where);
  hall.place("stand", group, meshes.stand, HallMaterial::Brass);
  site.instance = hall.place("globe", group, meshes.globe, HallMaterial::DarkGlass, at(0, 1.6, 0));
  site.position = inWorld(hall, group, {0, 1.6f, 0});
  hall.lamp(site);
}

// One stand in front of each column, which it lights from below, and four in the apse.
void addCandleStands(HallBuilder& hall, const Meshes& meshes) {
  int number = 0;
  for (int boundary = kBays; boundary >= 0; --boundary)
    for (const double side : {1.0, -1.0})
      addCandleStand(hall, meshes, fmt::format("candle stand {}", ++number),
                     at(side * (kColumnX - 0.9), 0,
                        bayBoundary(boundary) + (boundary == 0       ? 0.75
                                                 : boundary == kBays ? -0.75
                                                                     : 0)),
                     {{}, kCandle, 0.32f, 6.0f, kNoInstance});
  for (const double turn : {0.07, 0.17, 0.33, 0.43}) {
    const dvec2 cs = onCircle(turn);
    addCandleStand(hall, meshes, fmt::format("candle stand {}", ++number),
                   at(2.2 * cs.x, kApseSteps * kApseStep, -kHalfLength - 2.2 * cs.y),
                   {{}, kCandle, 0.7f, 7.0f, kNoInstance});
  }
}

}  // namespace

void addLamps(HallBuilder& hall) {
  const Detail& d = hall.detail;
  const Meshes meshes{hall.mesh(lanternFrame(d)), hall.mesh(lanternGlass(d)), hall.mesh(wheel(d)), hall.mesh(globe(d)),
                      hall.mesh(candleStand(d))};
  const double vaultCrown = kVaultSpring + kVaultRadius, archCrown = kArchSpring + kArchRadius;
  const double archLantern = 5.95, aisleLantern = 5.1, galleryLantern = 10.75;
  const uint32_t longChain = hall.mesh(chain(d, "chandelier chain", vaultCrown - kWheelHeight - 0.9));
  const uint32_t archChain = hall.mesh(chain(d, "arch chain", archCrown - archLantern));
  const uint32_t aisleChain = hall.mesh(chain(d, "aisle chain", kArchSpring + kAisleRise - 0.15 - aisleLantern));
  const uint32_t galleryChain = hall.mesh(chain(d, "gallery chain", kGalleryTop - galleryLantern));
  for (int bay = kBays - 1, number = 1; bay >= 0; bay -= 2)
    addChandelier(hall, meshes, number++, longChain, bayCenter(bay));
  int number = 0;
  for (int bay = kBays - 1; bay >= 0; --bay) {
    for (const double side : {1.0, -1.0}) {
      ++number;
      const double z = bayCenter(bay);
      addLantern(hall, meshes, fmt::format("arch lantern {}", number), archChain, at(side * kColumnX, archLantern, z),
                 {{}, kLantern, 1.3f, 8.5f, kNoInstance});
      addLantern(hall, meshes, fmt::format("aisle lantern {}", number), aisleChain, at(side * kAisleX, aisleLantern, z),
                 {{}, kLantern, 0.9f, 7.0f, kNoInstance});
      if (bay % 2 == 0)
        addLantern(hall, meshes, fmt::format("gallery lantern {}", number / 2 + 1), galleryChain,
                   at(side * (kColumnX + 1.2), galleryLantern, z), {{}, kGallery, 0.7f, 7.5f, kNoInstance});
    }
  }
  addCandleStands(hall, meshes);
}

}  // namespace latelight::scene::builtin::hall
