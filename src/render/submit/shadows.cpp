// Plans the shadows of a request: the maps of the scene's lights and their positions in the atlas, or the rays to them.
// Shaders fit the maps, and list the rays, of worlds that they place.
#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "render/lens/shadow_view.h"
#include "render/shadow/choose.h"
#include "render/shadow/plan.h"
#include "render/submit/renderer.h"
#include "render/submit/request.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

// The lights from which shaders derive those of worlds, whatever these emit.
struct LightsToPlace {
  std::vector<shared::Light> lights;
  std::vector<uint32_t> sources;
  std::span<const scene::Light> authored;

  explicit LightsToPlace(const GpuWorlds::PlacedLights& placed)
      : sources(placed.templates.size()), authored(placed.authored) {
    for (const shared::LightTemplate& light : placed.templates) lights.push_back(light.light[0]);
    std::iota(sources.begin(), sources.end(), 0u);
  }
  ShadowScene scene(const scene::Bounds& bounds) const { return {lights, sources, authored, bounds}; }
};

}  // namespace

// Returns true if shaders may fit all shadow maps of worlds that they place, or if there are none, or if rays find the
// shadows of lights that are the same in all views of a world.
bool Renderer::placesShadows(const Settings& s, const Poses& poses, WorldLights ownLights, bool ownJoints) const {
  if (s.shadows == ShadowFormat::None || !isLit(s)) return true;
  std::vector<scene::Light> lights = scene_.lights;
  if (const std::optional<scene::Light> sun = sunOf(s)) lights.push_back(*sun);
  if (std::ranges::all_of(lights, &scene::Light::removed)) return true;
  if (s.shadows == ShadowFormat::Rays) {
    const auto isArea = [](const scene::Light& light) { return !light.removed && shared::lightIsArea(light.type); };
    const bool writesLights = ownLights == WorldLights::InArrays && std::ranges::none_of(lights, isArea);
    return (ownLights == WorldLights::OfScene || writesLights) && castsInAllViews(lights, s);
  }
  return poses.current.empty() && ownLights != WorldLights::InLists && !ownJoints &&
         mapsFitAtlas(lights, s.width, s.height, s);
}

bool Renderer::castsShadows(const Settings& settings) const {
  return settings.shadows != ShadowFormat::None && gpuScene_.lightCount() > 0 && isLit(settings) &&
         !state_.placedShadows;
}

// Selects the lights whose shadow maps shaders fit to the views of worlds, or whose rays they list for each world.
void Renderer::planPlacedShadows(const Settings& s, const WorldStates& worlds) {
  state_.placedShadows = nullptr;
  if (!worlds.inputs || !castsShadows(s)) return;
  if (s.shadows == ShadowFormat::Rays) return listRays(s);
  std::vector<shared::View> views;
  for (const scene::Camera& camera : worlds.inputs->cameras)
    views.push_back(shadowView(camera, s.width, s.height, gpuScene_));
  if (gpuScene_.worlds().placesLights()) {
    const LightsToPlace lights(gpuScene_.worlds().placedLights());
    placedShadows_ = render::planPlacedShadows(lights.scene(gpuScene_.deviceBounds()), views, s);
    gpuScene_.castMaps(placedShadows_.casters);
  } else {
    placedShadows_ = render::planPlacedShadows(shadowSceneOf(gpuScene_), views, s);
  }
  state_.placedShadows = &placedShadows_;
}

// Selects the lights of worlds whose shadows rays find, if shaders write these lights.
void Renderer::listRays(const Settings& settings) {
  if (!gpuScene_.worlds().placesLights()) return;
  const LightsToPlace lights(gpuScene_.worlds().placedLights());
  gpuScene_.castRays(raysOfLights(lights.scene({}), settings));
}

// Plans the maps for the full pictures without jitter, so that the samples and strips of a picture share the positions
// of their maps in the atlas.
ShadowPlan Renderer::planShadows(std::span<const scene::Camera> cameras, const Settings& settings) const {
  if (!castsShadows(settings)) return {};
  std::vector<shared::View> views;
  for (const scene::Camera& camera : cameras)
    views.push_back(shadowView(camera, settings.width, settings.height, gpuScene_));
  std::vector<ShadowScene> worlds;
  for (uint32_t world = 0; world < std::max(1u, gpuScene_.worlds().count()); ++world)
    worlds.push_back(shadowSceneOf(gpuScene_, world));
  return render::planShadows(worlds, views, settings);
}

// Returns the rays to the lights of worlds that shaders place.
ShadowPlan Renderer::planPlacedRays(const Settings& settings) const {
  if (!gpuScene_.worlds().placesLights()) return render::planPlacedRays(shadowSceneOf(gpuScene_), settings);
  const GpuWorlds::PlacedLights& lights = gpuScene_.worlds().placedLights();
  return {.placed = {lights.casters, lights.mostRays, lights.rayShadows, lights.others}};
}

// Returns null if no light casts shadows. From here on, newly planned maps may replace earlier ones in the atlas.
std::shared_ptr<FrameShadows> Renderer::placeShadows(ShadowPlan plan, const Settings& settings) {
  if (placedRays_ && placedRays_->repeats(plan, gpuScene_)) return placedRays_;
  ShadowMapCache& kept = shadowMaps_[rastersInCompute(settings)];
  auto shadows = std::make_shared<FrameShadows>(device_, gpuScene_, std::move(plan), settings, kept);
  if (shadows->empty()) return nullptr;
  if (shadows->plan().sameInAllViews) placedRays_ = shadows;
  return shadows;
}

}  // namespace latelight::render
