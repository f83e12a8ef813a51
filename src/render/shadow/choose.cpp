// Selection of shadow casters. Lights are ranked by importance (Candidate::operator<), get tiles of about the
// resolution of the picture (sizeOf), and tiles are halved until they fit into the shadow atlas (fit).
#include "render/shadow/choose.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "render/shadow/atlas.h"
#include "render/shadow/cascades.h"
#include "render/shadow/page_push.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

constexpr uint32_t kLargestTile = 2048, kMinCascade = 128;
static_assert(kLargestTile <= 32 * shared::kShadowPage, "a row of a map's pages is a word");
static_assert(kMinShadowTile == shared::kShadowCell);

// --- selection ------------------------------------------------------------------------------------------------------

// The distance to which the light reaches within the scene, in meters.
float reachIn(const ShadowScene& scene, const shared::Light& light) {
  return std::min(light.radius, static_cast<float>(2 * scene.bounds.radius()));
}

// The illuminance at the eye in lux. For a directional light it is the same everywhere.
float importance(const shared::Light& light, const ShadowScene& scene, const shared::View& view) {
  const float candela = shared::maxChannel(light.intensity);
  if (shared::lightIsDirectional(light.type)) return candela;
  const glm::vec3 to = light.position - view.eye;
  const float nearest = 0.01f * reachIn(scene, light);
  return candela / std::max(glm::dot(to, to), nearest * nearest);
}

bool mayCast(const scene::Light& light, const ShadowLights& requested) {
  const bool named = requested.names.empty() || std::ranges::count(requested.names, light.name) > 0;
  return light.castShadow.value_or(true) && named;
}

size_t mostCasters(const ShadowLights& requested) {
  return requested.automatic ? kAutomaticShadows : requested.most;
}

struct Candidate {
  uint32_t light, source;
  bool directional, asked;  // asked: the scene itself requests shadows of this light
  float importance;
  // Orders by decreasing importance; no two candidates compare equal.
  bool operator<(const Candidate& other) const {
    if (asked != other.asked) return asked;
    if (directional != other.directional) return directional;
    if (importance != other.importance) return importance > other.importance;
    return source < other.source;
  }
};

std::vector<Candidate> candidates(const ShadowScene& scene, const shared::View& view, const ShadowLights& requested,
                                  bool anyCascade) {
  const Frustum frustum(view);
  std::vector<Candidate> found;
  for (uint32_t i = 0; i < scene.lights.size(); ++i) {
    const shared::Light& light = scene.lights[i];
    const scene::Light& authored = scene.authored[scene.sources[i]];
    const bool directional = shared::lightIsDirectional(light.type);
    if (!mayCast(authored, requested)) continue;
    if (directional ? !anyCascade : !frustum.touches({light.position, light.radius})) continue;
    found.push_back(
        {i, scene.sources[i], directional, authored.castShadow.value_or(false), importance(light, scene, view)});
  }
  const size_t count = std::min<size_t>(found.size(), mostCasters(requested));
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), found.end());
  found.resize(count);
  return found;
}

// --- sizes ----------------------------------------------------------------------------------------------------------

// The nearest power of two by ratio, clamped to bounds that are powers of two themselves.
uint32_t tileSize(double texels, uint32_t least, uint32_t most) {
  const double clamped = std::clamp(texels, double(least), double(most));
  return 1u << static_cast<uint32_t>(std::lround(std::log2(clamped)));
}

// Maps have about as many texels as pixels: a cascade is about as wide as the picture, a spot light's map as wide as
// the light's sphere on screen, and a cube face half as wide.
uint32_t sizeOf(const shared::Light& light, const ShadowScene& scene, const shared::View& view, uint32_t maps) {
  const double picture = std::max(view.size.x, view.size.y);
  const uint32_t cascade = cascadeSize(picture);
  if (shared::lightIsDirectional(light.type)) return cascade;
  const double reach = reachIn(scene, light);
  const double distance = std::max<double>(glm::length(light.position - view.eye), 0.5 * reach);
  const bool perspective = view.projection.kind == shared::kPerspective;
  const double pixels = reach * view.projection.V * view.size.y / (perspective ? distance : 1);
  return tileSize(maps == kCubeFaces ? 0.5 * pixels : pixels, kMinShadowTile, cascade);
}

uint64_t areaOf(const std::vector<ShadowCaster>& casters) {
  uint64_t area = 0;
  for (const ShadowCaster& caster : casters) area += uint64_t{caster.maps} * caster.size * caster.size;
  return area;
}

// Halves the sizes larger than `least`. Returns false if there are none.
bool halve(std::vector<ShadowCaster>& casters, const ShadowScene& scene, bool directionalToo, uint32_t least) {
  bool halved = false;
  for (ShadowCaster& caster : casters) {
    const bool directional = shared::lightIsDirectional(scene.lights[caster.light].type);
    if ((directional && !directionalToo) || caster.size <= least) continue;
    caster.size /= 2;
    halved = true;
  }
  return halved;
}

// Reduces sizes until all tiles fit into `room` texels, then drops lights. Returns the number of dropped lights.
size_t fit(std::vector<ShadowCaster>& casters, const ShadowScene& scene, uint64_t budget) {
  constexpr uint32_t kFine = 256;  // only local lights' tiles are halved down to this size, then all tiles
  while (areaOf(casters) > budget && halve(casters, scene, false, kFine)) {
  }
  while (areaOf(casters) > budget && halve(casters, scene, true, kMinShadowTile)) {
  }
  const size_t before = casters.size();
  uint64_t area = areaOf(casters);
  for (; area > budget; casters.pop_back())
    area -= uint64_t{casters.back().maps} * casters.back().size * casters.back().size;
  return before - casters.size();
}

// Returns true if a light of a scene casts shadows in the views that select it.
bool castsIn(const Settings& settings, const scene::Light& light) {
  return !light.removed && !shared::lightIsArea(light.type) && mayCast(light, settings.shadowLights);
}

}  // namespace

uint32_t mapCount(const shared::Light& light) {
  return shadowCone(light) ? 1 : kCubeFaces;
}

std::optional<double> shadowCone(const shared::Light& light) {
  constexpr double kWidest = 1.05, kNarrowest = 2e-3;  // radians; beyond 60 degrees a map consists mostly of rim
  if (!shared::lightHasCone(light.type)) return std::nullopt;
  // The rounding of spotOffset / spotScale changes a narrow cone's angle by up to 3.5e-4 radians.
  const double half = std::acos(std::clamp(-double{light.spotOffset} / light.spotScale, -1.0, 1.0)) + 1e-3;
  if (half > kWidest) return std::nullopt;
  return std::max(half, kNarrowest);
}

void checkShadowLights(const ShadowLights& requested, std::span<const scene::Light> lights) {
  for (const std::string& name : requested.names)
    if (std::none_of(lights.begin(), lights.end(), [&](const scene::Light& light) { return light.name == name; }))
      badUsage("no light is called \"{}\": --shadow-lights takes auto, all, none, a number, or names of lights", name);
}

uint32_t cascadeSize(double picture) {
  return tileSize(picture, kMinCascade, kLargestTile);
}

bool castsInAllViews(std::span<const scene::Light> lights, const Settings& settings) {
  const auto casts = [&](const scene::Light& light) { return castsIn(settings, light); };
  return static_cast<size_t>(std::ranges::count_if(lights, casts)) <= mostCasters(settings.shadowLights);
}

bool mapsFitAtlas(std::span<const scene::Light> lights, uint32_t width, uint32_t height, const Settings& settings) {
  uint64_t maps = 0;
  for (const scene::Light& light : lights)  // a spot light may have a cube, too
    if (castsIn(settings, light)) maps += shared::lightIsDirectional(light.type) ? kCascades : kCubeFaces;
  const uint64_t side = cascadeSize(std::max(width, height)),
                 budget = uint64_t{settings.shadowAtlas} * settings.shadowAtlas;
  return castsInAllViews(lights, settings) && side * side * maps <= budget;
}

std::vector<uint32_t> shadowCasters(const ShadowScene& scene, const Settings& settings) {
  checkShadowLights(settings.shadowLights, scene.authored);
  std::vector<uint32_t> casters;
  for (uint32_t i = 0; i < scene.lights.size(); ++i)
    if (castsIn(settings, scene.authored[scene.sources[i]])) casters.push_back(i);
  return casters;
}

std::vector<ShadowCaster> chooseShadowCasters(const ShadowScene& scene, const shared::View& view,
                                              const Settings& settings, uint32_t cascades) {
  const ShadowLights& requested = settings.shadowLights;
  checkShadowLights(requested, scene.authored);
  std::vector<ShadowCaster> casters;
  for (const Candidate& candidate : candidates(scene, view, requested, cascades > 0)) {
    const shared::Light& light = scene.lights[candidate.light];
    const uint32_t maps = candidate.directional ? cascades : mapCount(light);
    casters.push_back({candidate.light, maps, sizeOf(light, scene, view, maps)});
  }
  if (settings.shadows == ShadowFormat::Rays) return casters;
  const size_t asked = casters.size();
  const size_t dropped = fit(casters, scene, uint64_t{settings.shadowAtlas} * settings.shadowAtlas);
  if (dropped && !requested.automatic)
    warn("the {} most important of {} lights cast shadows: no more fit into a shadow atlas of {} texels",
         asked - dropped, asked, settings.shadowAtlas);
  return casters;
}

}  // namespace latelight::render
