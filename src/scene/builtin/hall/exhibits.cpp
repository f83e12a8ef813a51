// The hall's exhibits: objects of many shapes and materials on plinths under the arches, and a statue in the apse.
#include <fmt/format.h>

#include <memory>

#include "scene/builtin/hall/hall.h"
#include "scene/builtin/hall/occlusion.h"
#include "scene/builtin/profile.h"
#include "scene/builtin/random.h"
#include "scene/builtin/tube.h"

namespace latelight::scene::builtin::hall {
namespace {

constexpr double kPlinthTop = 1.0;
constexpr double kFigureFoot = kApseSteps * kApseStep;

MeshPlan plinth(const Detail& detail) {
  MeshPlan plan{"plinth", {}, shadeInHall({float(kColumnX), 0, 0}), {}};
  Profile p(0.05, 0);
  p.line(0.05, 0.1).arc(0.01, 0.16, -1, 2).line(0, 0.165).line(0, 0.86).segments(3, 1).arc(0.04, 0.91, -1, 2);
  p.line(0.06, 0.915).line(0.06, 0.98).line(0.05, kPlinthTop).line(-0.2, kPlinthTop);
  plan.add(sweepPolygon(p, square(0.3), true, detail.segments(1.5), detail, kMarbleTile));
  plan.add(quad({-0.1, kPlinthTop, 0.1}, {0.1, kPlinthTop, 0.1}, {0.1, kPlinthTop, -0.1}, {-0.1, kPlinthTop, -0.1}, 1,
                1, kMarbleTile));
  return plan;
}

// Every object on a plinth stands at y = 0 in its own frame.
MeshPlan urn(const Detail& detail) {
  MeshPlan plan{"urn", {}, {}, {}};
  Profile p(0, 0);
  p.whole();
  p.line(0.13, 0).line(0.13, 0.03).arc(0.115, 0.05, 1, 1.5).line(0.07, 0.07).smooth();
  p.curve({{0.05, 0.1}, {0.06, 0.13}, {0.17, 0.3}, {0.22, 0.5}, {0.17, 0.66}, {0.085, 0.74}, {0.08, 0.8}}, 2);
  p.line(0.1, 0.81)
      .arc(0.13, 0.85, 0.6, 2)
      .arc(0.115, 0.865, 1.4, 2)
      .smooth()
      .curve({{0.075, 0.82}, {0.07, 0.74}, {0.12, 0.66}}, 1.5);
  p.smooth().curve({{0.1, 0.6}, {0, 0.58}}, 1.5);
  plan.add(sweep(p, circle(Axis{}, detail.segments(28, 8), 0.15), detail));
  for (const double turn : {0.0, 0.5}) {
    const auto curve = [](double v) {
      const dvec2 cs = onCircle(0.29 - 0.52 * v);
      return dvec2(0.15 + 0.1 * cs.x + 0.02 * (1 - v), 0.66 + 0.12 * cs.y);
    };
    plan.add(tube(radialCurve(turn, curve, [](double) { return dvec2(0.018, 0.014); }), detail.segments(7, 4),
                  detail.segments(12, 6), false, false));
  }
  return plan;
}

MeshPlan ball(const Detail& detail) {
  MeshPlan plan{"ball", {}, {}, {}};
  Profile p(0, 0.04);
  p.arc(0, 0.64, 2).segments(18, 6);
  plan.add(sweep(p, circle(Axis{}, detail.segments(32, 10), 0.3), detail));
  Profile stand(0.16, 0);
  stand.line(0.16, 0.02).arc(0.1, 0.07, -1, 2).line(0.09, 0.07);
  plan.add(sweep(stand, circle(Axis{}, detail.segments(20, 8), 0.15), detail));
  return plan;
}

// A (2, 3) torus knot. The tube's normal is the torus's normal, so that the frame closes.
MeshPlan knot(const Detail& detail) {
  MeshPlan plan{"knot", {}, {}, {}};
  const auto point = [](double v) {
    const dvec2 around = onCircle(2 * v), about = onCircle(3 * v);
    const double r = 0.21 + 0.095 * about.x;
    return dvec3(r * around.x, 0.385 + r * around.y, 0.105 * about.y);
  };
  const auto curve = [point](double v) {
    const dvec2 around = onCircle(2 * v), about = onCircle(3 * v);
    const dvec3 normal = dvec3(around.x, around.y, 0) * about.x + dvec3(0, 0, about.y);
    return TubePoint{point(v), point(v + 1e-4) - point(v - 1e-4), normal, 0.06, 0.06};
  };
  plan.add(tube(curve, detail.segments(12, 5), detail.segments(64, 24), true, false, {1, 6}));
  Profile stand(0.12, 0);
  stand.line(0.12, 0.02).line(0.03, 0.05).line(0.03, 0.1).line(0, 0.1);
  plan.add(sweep(stand, circle(Axis{}, detail.segments(16, 6), 0.1), detail));
  return plan;
}

// The superformula's radius at an angle in turns (Gielis 2003, A generic geometric transformation that unifies a wide
// range of natural and abstract shapes).
double superRadius(double turns, double m, double n1, double n2, double n3) {
  const dvec2 cs = onCircle(turns * m / 4);
  const double sum = power(std::abs(cs.x), n2) + power(std::abs(cs.y), n3);
  return power(sum, -1 / n1);
}

MeshPlan supershape(const Detail& detail, double m, double n1, double n2, double n3, const char* name) {
  MeshPlan plan{name, {}, {}, {}};
  Patch patch;
  patch.columns = detail.segments(40, 12);
  patch.rows = detail.segments(24, 6);
  patch.closedU = true;
  patch.averaged = true;
  patch.pointV0 = patch.pointV1 = true;
  patch.surface = surfaceOf(
      [=](double u, double v) {
        const double latitude = 0.25 - 0.5 * v;  // in turns, from top to bottom: the shape's axis is -Y
        const double r1 = superRadius(u, m, n1, n2, n3), r2 = superRadius(latitude, 4, 4, 4, 4);
        const dvec2 around = onCircle(u), up = onCircle(latitude);
        const double across = v <= 0 || v >= 1 ? 0 : 0.27 * r1 * r2 * up.x;
        return dvec3(across * around.x, 0.33 - 0.3 * r2 * up.y, -across * around.y);
      },
      [](double u, double v) { return dvec2(2 * u, -v); });
  plan.add(std::move(patch));
  return plan;
}

// A vase of twisted ribs, with matching grooves inside.
MeshPlan twistedVase(const Detail& detail) {
  MeshPlan plan{"twisted vase", {}, {}, {}};
  Profile p(0.1, 0);
  p.whole();
  p.line(0.11, 0.02).curve({{0.17, 0.16}, {0.215, 0.36}, {0.17, 0.58}, {0.115, 0.7}, {0.14, 0.8}}, 3);
  p.line(0.122, 0.805).curve({{0.098, 0.7}, {0.15, 0.58}, {0.19, 0.36}, {0.05, 0.1}}, 2);
  for (Profile::Run& points : p.sample(detail)) {
    const auto run = std::make_shared<const Profile::Run>(std::move(points));
    Patch patch;
    patch.columns = 12 * detail.segments(4, 2);
    patch.rows = static_cast<uint32_t>(run->size() - 1);
    patch.closedU = true;
    patch.averaged = true;
    patch.surface = [run, rows = patch.rows](double u, double v) {
      const dvec2 at = (*run)[static_cast<size_t>(v * rows + 0.5)].position;
      const double rib = std::abs(sinQuarters(24 * (u + 0.35 * at.y)));
      const double r = at.x * (1 - 0.13 * (1 - rib) * std::min(1.0, 6 * at.y));
      const dvec2 cs = onCircle(u);
      SurfacePoint point;
      point.position = {r * cs.x, at.y, -r * cs.y};
      point.normal = {cs.x, 0, -cs.y};  // placeholder until the triangles' normals are known
      point.tangent = {-cs.y, 0, -cs.x};
      point.uv = {2 * u, -2 * at.y};
      return point;
    };
    plan.add(std::move(patch));
  }
  return plan;
}

// A draped figure: a flattened surface of revolution with folds that fall and gather.
MeshPlan figure(const Detail& detail) {
  MeshPlan plan{"figure", {}, {}, {}};
  const std::vector<dvec2> outline{{0.34, 0},    {0.31, 0.12}, {0.27, 0.45}, {0.25, 0.85},  {0.245, 1.1}, {0.22, 1.24},
                                   {0.24, 1.42}, {0.27, 1.6},  {0.25, 1.7},  {0.115, 1.79}, {0.075, 1.84}};
  Profile body(0.36, 0);
  body.curve(outline, 2);
  const auto runs = body.sample(Detail{8});
  const auto run = std::make_shared<const Profile::Run>(runs.front());
  const auto radius = [run](double y) {
    size_t i = 1;
    while (i + 1 < run->size() && (*run)[i].position.y < y) ++i;
    const dvec2 a = (*run)[i - 1].position, b = (*run)[i].position;
    const double t = std::clamp((y - a.y) / std::max(1e-9, b.y - a.y), 0.0, 1.0);
    return a.x + (b.x - a.x) * t;
  };
  Patch robe;
  robe.columns = detail.segments(72, 20);
  robe.rows = detail.segments(30, 12);
  robe.closedU = true;
  robe.averaged = true;
  robe.surface = surfaceOf(
      [=](double u, double v) {
        const double y = 1.84 * v;
        const double folds = std::max(0.0, 1 - y / 1.75);
        const double wave = sinQuarters(4 * (9 * u + 0.25 * y + 0.06 * sinQuarters(4 * (2 * u) + 5 * y)));
        const double cape = 0.5 + 0.5 * sinQuarters(4 * (u + 0.12) + 2.2 * (1 - y / 1.3));
        const double r = radius(y) * (1 + 0.085 * folds * wave + 0.05 * cape * folds);
        const dvec2 cs = onCircle(u);
        return dvec3(r * cs.x, y, -0.78 * r * cs.y);
      },
      [](double u, double v) { return dvec2(u, -v) * 1.2; });
  plan.add(std::move(robe));
  Profile head(0, 1.8);
  head.smooth().curve({{0.075, 1.85}, {0.11, 1.95}, {0.115, 2.03}, {0.08, 2.12}, {0, 2.15}}, 2.5);
  std::vector<Patch> skull =
      sweep(head, circle({{0, 0, 0.03}, {0, 1, 0}, {1, 0, 0}}, detail.segments(20, 8), 0.1), detail);
  plan.add(std::move(skull));
  // Arms that join in front.
  for (const double side : {-1.0, 1.0}) {
    const auto arm = [side](double v) {
      const double b = v * v;
      const dvec3 p(side * (0.27 * (1 - b) + 0.02 * b + 0.05 * sinQuarters(2 * v)), 1.6 - 0.5 * v + 0.28 * b,
                    0.02 + 0.26 * v);
      const double w = 0.02 + 0.055 * std::sqrt(std::max(0.0, 1 - v * v * v)) * std::min(1.0, 8 * v + 0.5);
      return TubePoint{p, dvec3(-side * (0.4 * v + 0.02), -0.5 + 0.56 * v, 0.26), {0, 1, 0.5}, w, w};
    };
    plan.add(tube(arm, detail.segments(10, 5), detail.segments(12, 6), false, false));
  }
  plan.shade = [](vec3 p, vec3) { return 0.6f + 0.4f * std::clamp(p.y / 0.5f, 0.0f, 1.0f); };
  return plan;
}

MeshPlan drum(const Detail& detail) {
  MeshPlan plan{"figure's drum", {}, {}, {}};
  Profile p(0.75, kFigureFoot);
  p.line(0.75, kFigureFoot + 0.14).arc(0.66, kFigureFoot + 0.2, -1, 2).line(0.62, kFigureFoot + 0.2);
  p.line(0.62, kFigureFoot + 0.95).segments(3, 1).arc(0.69, kFigureFoot + 1.02, -1, 2).line(0.72, kFigureFoot + 1.025);
  p.line(0.72, kFigureFoot + 1.1).line(0, kFigureFoot + 1.1);
  plan.add(sweep(p, circle(Axis{}, detail.segments(32, 12), 0.65), detail, kMarbleTile));
  return plan;
}

// Five panes over a plinth.
MeshPlan glassCase() {
  MeshPlan plan{"glass case", {}, {}, {}};
  constexpr double kHalf = 0.34, kTop = 0.96;
  const auto corner = [](int quarters, double height) {
    const dvec2 corners[] = {{-kHalf, kHalf}, {kHalf, kHalf}, {kHalf, -kHalf}, {-kHalf, -kHalf}};
    const dvec2 c = corners[quarters % 4];
    return dvec3(c.x, height, c.y);
  };
  for (int side = 0; side < 4; ++side)
    plan.add(quad(corner(side, 0), corner(side + 1, 0), corner(side + 1, kTop), corner(side, kTop), 1, 1));
  plan.add(quad(corner(0, kTop), corner(1, kTop), corner(2, kTop), corner(3, kTop), 1, 1));
  return plan;
}

}  // namespace

void addExhibits(HallBuilder& hall) {
  const Detail& d = hall.detail;
  const uint32_t bodies[] = {hall.mesh(urn(d)),
                             hall.mesh(knot(d)),
                             hall.mesh(ball(d)),
                             hall.mesh(twistedVase(d)),
                             hall.mesh(supershape(d, 6, 1, 1.7, 1.7, "flower")),
                             hall.mesh(supershape(d, 7, 0.6, 1.1, 0.9, "star"))};
  const uint32_t stand = hall.mesh(plinth(d)), statue = hall.mesh(figure(d)), base = hall.mesh(drum(d));
  constexpr HallMaterial kMaterials[] = {HallMaterial::Ceramic, HallMaterial::Copper, HallMaterial::Obsidian,
                                         HallMaterial::Celadon, HallMaterial::Brass,  HallMaterial::Bronze,
                                         HallMaterial::Steel,   HallMaterial::Marble};
  Random random(hall.seed, 5);
  uint32_t body = random.below(6), material = random.below(8);
  constexpr HallMaterial kGlasses[] = {HallMaterial::AmberGlass, HallMaterial::BlueGlass, HallMaterial::GreenGlass};
  const uint32_t panes = hall.glass ? hall.mesh(glassCase()) : 0;
  const uint32_t exhibits = hall.group("exhibits", SceneBuilder::kRoot);
  for (int bay = kBays - 1; bay >= 0; --bay) {
    for (int side = 0; side < 2; ++side) {
      const std::string number = std::to_string(2 * (kBays - 1 - bay) + side + 1);
      const mat4 where = rotatedAt(side ? -kColumnX : kColumnX, 0, bayCenter(bay), static_cast<int>(random.below(4)));
      const uint32_t group = hall.group("exhibit " + number, exhibits, where);
      hall.place("plinth", group, stand, (bay + side) % 2 ? HallMaterial::BlackMarble : HallMaterial::Marble);
      const bool blown = hall.glass && (bay + side) % 2 == 0;
      hall.place("body", group, bodies[body], blown ? kGlasses[(bay + side) / 2 % 3] : kMaterials[material],
                 at(0, kPlinthTop, 0));
      if (hall.glass) hall.place("case", group, panes, HallMaterial::CaseGlass, at(0, kPlinthTop, 0));
      body = (body + 1 + random.below(2)) % 6;
      material = (material + 1 + random.below(3)) % 8;
    }
  }
  const uint32_t group = hall.group("figure", exhibits, at(0, 0, -kHalfLength));
  hall.place("drum", group, base, HallMaterial::BlackMarble);
  hall.place("body", group, statue, HallMaterial::Marble, at(0, kFigureFoot + 1.1, 0));
}

}  // namespace latelight::scene::builtin::hall
