// The camera source "scene": the scene's own cameras, all or by name.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "data/cameras/source.h"

namespace latelight::data {

std::vector<Shot> shotsOfScene(Spec& spec, const CameraContext& context) {
  const std::vector<scene::Camera>& cameras = context.ownCameras;
  if (cameras.empty())
    badUsage("{}: {} has no cameras of its own: add some, for example with --cameras '{}'", spec.path(),
             context.scene.source, R"({"type": "orbit", "count": 8})");
  const std::vector<std::string> chosen = spec.has("names") ? spec.texts("names") : std::vector<std::string>();
  uint64_t names = 0;
  for (const scene::Camera& camera : cameras) names += chosen.empty() ? camera.name.size() : 0;
  for (const std::string& name : chosen) names += name.size();
  context.claim(spec, chosen.empty() ? cameras.size() : chosen.size(), names);
  std::vector<Shot> shots;
  const auto add = [&](const scene::Camera& camera) {
    shots.push_back(toShot(camera, context.scene));
    shots.back().sceneCamera = static_cast<uint32_t>(&camera - cameras.data());
  };
  if (!spec.has("names")) {
    for (const scene::Camera& camera : cameras) add(camera);
    return shots;
  }
  for (const std::string& name : chosen) {
    const auto camera = std::ranges::find(cameras, name, &scene::Camera::name);
    if (camera == cameras.end())
      badUsage("{}: {} has no camera \"{}\"", spec.pathOf("names"), context.scene.source, name);
    add(*camera);
  }
  return shots;
}

}  // namespace latelight::data
