// Projections of shadow maps (Williams 1978, Casting Curved Shadows on Curved Surfaces, SIGGRAPH). A directional light
// has one orthographic map per cascade (cascades.h), a spot light one perspective map, and a point or wide spot light
// the six faces of a cube. Depth is linear in meters between the near and far end of a map. Inputs: the lights and
// bounds of the scene (ShadowScene) and the views. Output: ShadowPlan, in which equal maps of several views appear
// once.
#include "render/shadow/plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <compare>
#include <map>

#include "base/parallel.h"
#include "render/frame/view.h"
#include "render/shadow/cascades.h"
#include "render/shadow/choose.h"
#include "shared/light.h"
#include "shared/shadow.h"

namespace latelight::render {

namespace {

using glm::dvec3;

// Margin in texels at each side of a tile, for the filter radius, the normal offset and half a texel of snapping.
constexpr uint32_t kMargin = 4;

struct Axes {
  dvec3 right, away, up;
};

Axes axesAlong(dvec3 away) {
  const dvec3 other = std::abs(away.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  const dvec3 right = glm::normalize(glm::cross(away, other));
  return {right, away, glm::cross(right, away)};
}

std::array<Axes, kCubeFaces> cubeAxes() {  // numbered as in shadowFace()
  return {axesAlong({1, 0, 0}),  axesAlong({-1, 0, 0}), axesAlong({0, 1, 0}),
          axesAlong({0, -1, 0}), axesAlong({0, 0, 1}),  axesAlong({0, 0, -1})};
}

// The minimum and maximum of a measure over the corners of the bounds, such as the distance from a plane.
struct Interval {
  double low = 1e300, high = -1e300;
};
template <typename Measure>
Interval overCorners(const scene::Bounds& bounds, const Measure& measure) {
  Interval interval;
  for (int corner = 0; corner < 8; ++corner) {
    const double value =
        measure(dvec3(corner & 1 ? bounds.max.x : bounds.min.x, corner & 2 ? bounds.max.y : bounds.min.y,
                      corner & 4 ? bounds.max.z : bounds.min.z));
    interval.low = std::min(interval.low, value);
    interval.high = std::max(interval.high, value);
  }
  return interval;
}

// The projection of a map, before it has a tile.
struct Frame {
  Axes axes;
  dvec3 origin{0};
  bool perspective = false;
  double half = 1;                // half of its width: meters at 1 m distance, or meters if orthographic
  double across = 0, upward = 0;  // center relative to the origin, meters; orthographic maps only
  double near = 0, far = 1;       // meters along `away`
};

shared::View viewOf(const Frame& f, double scale, uint32_t size) {
  shared::View view{};
  const std::array<dvec3, 3> rows{f.axes.right, f.axes.away, f.axes.up};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      view.worldToView[column][row] = static_cast<float>(rows[row][column] * scale);
      view.viewToWorld[row][column] = static_cast<float>(rows[row][column] / scale);
    }
    view.worldToView[3][row] = static_cast<float>(-glm::dot(rows[row], f.origin) * scale);
  }
  placeEye(view, f.origin);
  view.viewToWorld[3] = view.eye;
  view.size = {static_cast<float>(size), static_cast<float>(size)};
  shared::Projection& p = view.projection;
  p.kind = f.perspective ? shared::kPerspective : shared::kOrthographic;
  p.H = p.V = static_cast<float>(1 / f.half);
  p.X = static_cast<float>(-f.across / f.half);
  p.Z = static_cast<float>(-f.upward / f.half);
  // z before the division by w is half of the map's depth: 0 at `near` and 1/2 at `far`. Because it stays well below w,
  // rounding does not decide which geometry is clipped at the far end.
  p.A = static_cast<float>(0.5 / ((f.far - f.near) * scale));
  p.B = static_cast<float>(-0.5 * f.near / (f.far - f.near));
  return view;
}

glm::vec4 row(dvec3 v, double w) {
  return {glm::vec3(v), static_cast<float>(w)};
}

shared::ShadowMap mapOf(const Frame& f, uint32_t size) {
  const double half = 0.5 * size;
  const double h = half / f.half;  // texels per meter (at 1 m)
  const Axes& a = f.axes;
  const double right = glm::dot(a.right, f.origin), away = glm::dot(a.away, f.origin), up = glm::dot(a.up, f.origin);
  shared::ShadowMap m{};
  if (f.perspective) {
    m.across = row(a.right * h + a.away * half, -(right * h + away * half));
    m.down = row(a.away * half - a.up * h, -(away * half - up * h));
  } else {
    m.across = row(a.right * h, half - (right + f.across) * h);
    m.down = row(a.up * -h, half + (up + f.upward) * h);
  }
  m.away = row(a.away, -away);
  m.depthScale = static_cast<float>(1 / (f.far - f.near));
  m.depthOffset = static_cast<float>(-f.near / (f.far - f.near));
  m.texel = static_cast<float>(1 / h);
  m.perspective = f.perspective ? 1.0f : 0.0f;
  m.size = static_cast<float>(size);
  return m;
}

double withMargin(double half, uint32_t size) {
  return half * size / (size - 2.0 * kMargin);
}

Frame cascadeFrame(const Axes& axes, const Sphere& sphere, const Interval& depths, uint32_t size) {
  Frame f{.axes = axes, .half = withMargin(sphere.radius, size)};
  // Snapped to multiples of a texel from the world's origin, so a texel covers the same positions as the view moves.
  const double texel = 2 * f.half / size;
  f.across = std::round(glm::dot(axes.right, dvec3(sphere.center)) / texel) * texel;
  f.upward = std::round(glm::dot(axes.up, dvec3(sphere.center)) / texel) * texel;
  const double margin = 1e-3 * (depths.high - depths.low) + 1e-6;
  f.near = depths.low - margin;
  f.far = depths.high + margin;
  return f;
}

// The tangent of half the angle of a point or spot light's maps.
double tangentOf(const shared::Light& light) {
  const std::optional<double> cone = shadowCone(light);
  return cone ? std::tan(*cone) : 1;
}

// Geometry nearer than `radius`, the light's own size, is part of the fixture, such as its glass, and casts no shadow.
Frame localFrame(const shared::Light& light, const Axes& axes, double tangent, double radius,
                 const scene::Bounds& bounds, uint32_t size) {
  const dvec3 origin(light.position);
  const double farthest = overCorners(bounds, [&](dvec3 p) { return glm::length(p - origin); }).high;
  Frame f{.axes = axes, .origin = origin, .perspective = true, .half = withMargin(tangent, size)};
  f.far = 1.001 * std::min<double>(light.radius, farthest) + 1e-6;
  // Linear depth needs no near plane. However, coordinates are rounded, and a surface that contains the light must not
  // occlude half of the world.
  const double rounding = 1e-5 * std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
  f.near = std::min(std::max(radius, std::min(rounding, 1e-4 * f.far)), 0.5 * f.far);
  return f;
}

// The maximum by which stored depth is below the depth that was written, because of quantization or rounding.
float slackOf(uint32_t format) {
  constexpr float kRounding = 2e-6f;
  if (format == shared::kShadowD16) return 1.0f / 65535.0f + kRounding;
  return kRounding;
}

// The maps of one light.
struct LightMaps {
  std::vector<ShadowView> views;
  std::vector<shared::ShadowMap> maps;
};

struct Planner {
  const ShadowScene& scene;
  uint32_t world;
  const Settings& settings;
  uint32_t format;

  double lightRadius(const shared::Light& light, uint32_t index) const {
    const float own = scene.authored[scene.sources[index]].size;
    if (shared::lightIsDirectional(light.type)) return std::tan(0.5 * (own > 0 ? own : settings.sunAngle));
    return own > 0 ? own : settings.lightSize;
  }

  void addMap(LightMaps& to, const Frame& f, uint32_t size, float lightSize,
              const std::optional<Sphere>& within) const {
    shared::ShadowMap& map = to.maps.emplace_back(mapOf(f, size));
    map.lightSize = lightSize;
    map.depthSlack = slackOf(format);
    const double scale = f.perspective ? 1 / f.far : 1;
    const double unit = map.texel * map.depthScale * (f.perspective ? f.far : 1);
    ShadowView& view = to.views.emplace_back(
        ShadowView{viewOf(f, 1, size), viewOf(f, scale, size), size, static_cast<float>(unit), within});
    view.view.world = view.drawn.world = world;
  }

  // `cascades` are the spheres of the view's cascades, used for directional lights.
  LightMaps mapsOf(const ShadowCaster& caster, std::span<const Sphere> cascades) const {
    LightMaps maps;
    const shared::Light& light = scene.lights[caster.light];
    const auto lightSize = static_cast<float>(lightRadius(light, caster.light));
    const dvec3 direction = glm::normalize(dvec3(light.direction));
    if (shared::lightIsDirectional(light.type)) {
      const Axes axes = axesAlong(direction);
      const Interval depths = overCorners(scene.bounds, [&](dvec3 p) { return glm::dot(axes.away, p); });
      for (const Sphere& sphere : cascades)
        addMap(maps, cascadeFrame(axes, sphere, depths, caster.size), caster.size, lightSize, std::nullopt);
      return maps;
    }
    const Sphere within{light.position, light.radius};
    const double own = scene.authored[scene.sources[caster.light]].size;
    for (uint32_t i = 0; i < mapCount(light); ++i) {
      const Axes axes = shadowCone(light) ? axesAlong(direction) : cubeAxes()[i];
      addMap(maps, localFrame(light, axes, tangentOf(light), own, scene.bounds, caster.size), caster.size, lightSize,
             within);
    }
    return maps;
  }
};

constexpr size_t kViewsAtOnce = 8, kLightsAtOnce = 4;  // per task of a worker thread

// The cascades and shadow casters of a view.
struct Chosen {
  std::vector<Sphere> cascades;
  std::vector<ShadowCaster> casters;
};

std::vector<Chosen> choose(std::span<const ShadowScene> worlds, std::span<const shared::View> views,
                           const Settings& settings) {
  std::vector<Chosen> chosen(views.size());
  parallelFor(views.size(), kViewsAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const ShadowScene& scene = worlds[views[i].world];
      if (scene.bounds.empty()) continue;
      chosen[i].cascades = fitCascades(views[i], scene.bounds);
      chosen[i].casters =
          chooseShadowCasters(scene, views[i], settings, static_cast<uint32_t>(chosen[i].cascades.size()));
    }
  });
  return chosen;
}

// The key by which views share maps: world, light and size, and for a directional light also the view's cascades.
struct Shared {
  uint32_t world, light, size;
  std::vector<uint32_t> cascades;  // bits of their spheres' floats
  auto operator<=>(const Shared&) const = default;
};

Shared sharedOf(const ShadowScene& scene, uint32_t world, const ShadowCaster& caster,
                const std::vector<Sphere>& cascades) {
  Shared key{world, caster.light, caster.size, {}};
  if (shared::lightIsDirectional(scene.lights[caster.light].type))
    for (const Sphere& s : cascades)
      for (const float value : {s.center.x, s.center.y, s.center.z, s.radius})
        key.cascades.push_back(std::bit_cast<uint32_t>(value));
  return key;
}

// Returns the rays to a light. Penumbrae are those of lights with a radius; with PCSS all lights have one.
shared::RayShadow raysOf(const ShadowScene& scene, uint32_t light, const Settings& settings) {
  const bool soft = settings.shadowFilter == ShadowFilter::Pcss || scene.authored[scene.sources[light]].size > 0;
  const Planner planner{scene, 0, settings, shared::kShadowRays};
  const double size = soft ? planner.lightRadius(scene.lights[light], light) : 0;
  return {light, size > 0 ? settings.samples : 1, static_cast<float>(size), 0};
}

void addRays(ShadowPlan& plan, size_t view, const ShadowScene& scene, uint32_t light, const Settings& settings) {
  const shared::RayShadow rays = raysOf(scene, light, settings);
  plan.of[view].lights.push_back({light, static_cast<uint32_t>(plan.rays.size()), rays.rays});
  plan.rays.push_back(rays);
}

ShadowPlan planRays(std::span<const ShadowScene> worlds, std::span<const shared::View> views, const Settings& settings,
                    const std::vector<Chosen>& chosen) {
  ShadowPlan plan;
  plan.of.resize(views.size());
  for (const shared::View& view : views) plan.worlds.push_back(view.world);
  for (size_t view = 0; view < views.size(); ++view)
    for (const ShadowCaster& caster : chosen[view].casters)
      addRays(plan, view, worlds[views[view].world], caster.light, settings);
  return plan;
}

void addSun(PlacedShadowPlan& plan, const Planner& planner, uint32_t light) {
  const Frame f{.axes = axesAlong(glm::normalize(dvec3(planner.scene.lights[light].direction)))};
  LightMaps maps;
  planner.addMap(maps, f, plan.size, static_cast<float>(planner.lightRadius(planner.scene.lights[light], light)), {});
  plan.suns.push_back({maps.views[0].view, maps.maps[0]});
  for (const dvec3& axis : {f.axes.right, f.axes.away, f.axes.up})
    for (int i = 0; i < 3; ++i) plan.axes.push_back(axis[i]);
}

// Adds a point or spot light. Its maps' depths follow from the bounds of a world, which the device knows.
void addLocal(PlacedShadowPlan& plan, const ShadowScene& scene, uint32_t index) {
  const shared::Light& light = scene.lights[index];
  const uint32_t maps = mapCount(light);
  plan.locals.push_back(
      {light.position, light.radius, scene.authored[scene.sources[index]].size, maps, plan.localMaps, 0});
  plan.tangents.push_back(tangentOf(light));
  plan.localMaps += maps;
}

// Adds the maps of all local lights, size by size.
void addFaces(PlacedShadowPlan& plan, const Planner& planner, std::span<const uint32_t> locals) {
  for (uint32_t size = shared::kMinPlacedTile; !locals.empty() && size <= plan.size; size *= 2, ++plan.sizes)
    for (size_t i = 0; i < locals.size(); ++i) {
      const LightMaps maps = planner.mapsOf({locals[i], plan.locals[i].maps, size}, {});
      for (size_t face = 0; face < maps.maps.size(); ++face)
        plan.faces.push_back({maps.views[face].view, maps.maps[face]});
    }
}

}  // namespace

PlacedShadowPlan planPlacedShadows(const ShadowScene& scene, std::span<const shared::View> views,
                                   const Settings& settings) {
  PlacedShadowPlan plan{.lights = std::vector<shared::ShadowBits>((scene.lights.size() + 31) / 32),
                        .size = cascadeSize(std::max(views[0].size.x, views[0].size.y))};
  for (const shared::View& view : views)
    plan.depths.emplace_back(shared::viewDepth(view.projection, 1.0f), shared::viewDepth(view.projection, 0.0f));
  const Planner planner{scene, 0, settings, indexOf(settings.shadows)};
  std::vector<uint32_t> locals;
  for (const uint32_t light : shadowCasters(scene, settings)) {
    plan.lights[light / 32].lights |= 1u << (light % 32);
    if (shared::lightIsDirectional(scene.lights[light].type)) {
      addSun(plan, planner, light);
      plan.casters.push_back(scene.sources[light]);
    } else {
      addLocal(plan, scene, light);
      locals.push_back(light);
    }
  }
  for (const uint32_t light : locals) plan.casters.push_back(scene.sources[light]);
  addFaces(plan, planner, locals);
  for (size_t i = 1; i < plan.lights.size(); ++i)
    plan.lights[i].before = plan.lights[i - 1].before + static_cast<uint32_t>(std::popcount(plan.lights[i - 1].lights));
  return plan;
}

ShadowPlan planPlacedRays(const ShadowScene& scene, const Settings& settings) {
  ShadowPlan plan{.worlds = {0}, .sameInAllViews = true};
  plan.of.resize(1);
  for (const uint32_t light : shadowCasters(scene, settings)) addRays(plan, 0, scene, light, settings);
  return plan;
}

std::vector<shared::RayShadow> raysOfLights(const ShadowScene& scene, const Settings& settings) {
  std::vector<shared::RayShadow> rays(scene.lights.size(), {.light = shared::kRayNone});
  for (const uint32_t light : shadowCasters(scene, settings)) rays[light] = raysOf(scene, light, settings);
  return rays;
}

uint64_t shadowTexels(const Settings& s) {
  if (s.shadows == ShadowFormat::Rays) return 0;
  const uint64_t side = std::max(s.width, s.height), most = uint64_t{s.shadowAtlas} * s.shadowAtlas;
  const bool automatic = s.shadowLights.automatic;
  // A map is at most about as wide as the picture, with a factor of 2 in area for rounding to powers of two, and a cube
  // has six maps.
  return automatic ? std::min(most, 2 * 6 * kAutomaticShadows * side * side) : most;
}

ShadowPlan planShadows(std::span<const ShadowScene> worlds, std::span<const shared::View> views,
                       const Settings& settings) {
  ShadowPlan plan;
  plan.of.resize(views.size());
  const uint32_t format = indexOf(settings.shadows);
  if (format == shared::kShadowNone) return plan;
  const std::vector<Chosen> chosen = choose(worlds, views, settings);
  if (format == shared::kShadowRays) return planRays(worlds, views, settings, chosen);

  std::map<Shared, uint32_t> firsts;
  struct Distinct {
    const ShadowCaster* caster;
    const Chosen* chosen;
    uint32_t world;
  };
  std::vector<Distinct> distinct;
  uint32_t maps = 0;
  for (size_t view = 0; view < views.size(); ++view) {
    const uint32_t world = views[view].world;
    const ShadowScene& scene = worlds[world];
    for (const ShadowCaster& caster : chosen[view].casters) {
      const auto [first, isNew] = firsts.try_emplace(sharedOf(scene, world, caster, chosen[view].cascades), maps);
      if (isNew) {
        distinct.push_back({&caster, &chosen[view], world});
        maps += caster.maps;
      }
      ShadowPlan::OfView& of = plan.of[view];
      of.lights.push_back({caster.light, first->second, caster.maps});
      if (!of.sun && shared::lightIsDirectional(scene.lights[caster.light].type)) of.sun = caster.light;
    }
  }

  std::vector<LightMaps> planned(distinct.size());
  parallelFor(distinct.size(), kLightsAtOnce, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      planned[i] = Planner{worlds[distinct[i].world], distinct[i].world, settings, format}.mapsOf(
          *distinct[i].caster, distinct[i].chosen->cascades);
  });
  for (const LightMaps& light : planned) {
    plan.views.insert(plan.views.end(), light.views.begin(), light.views.end());
    plan.maps.insert(plan.maps.end(), light.maps.begin(), light.maps.end());
  }
  return plan;
}

}  // namespace latelight::render
