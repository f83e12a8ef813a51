#include "render/submit/scene_checks.h"

#include <optional>
#include <vector>

#include "base/error.h"
#include "render/shadow/choose.h"
#include "render/submit/renderer.h"
#include "render/submit/request.h"

namespace latelight::render {

void checkBackground(const Settings& settings, bool hasEnvironment) {
  if (settings.background.kind == Background::Environment && !hasEnvironment)
    badUsage("--background hdri requires an environment: choose one (a .hdr or .exr file, or studio)");
}

void checkShadowLightsOf(const scene::Scene& scene, const Settings& settings) {
  if (settings.shadowLights.names.empty() || settings.shadows == ShadowFormat::None || !isLit(settings)) return;
  std::vector<scene::Light> lights = scene.lights;
  std::erase_if(lights, [](const scene::Light& light) { return light.removed; });
  if (const std::optional<scene::Light> sun = sunOf(settings)) lights.push_back(*sun);
  if (!lights.empty()) checkShadowLights(settings.shadowLights, lights);
}

}  // namespace latelight::render
