#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "data/cameras/source.h"

namespace latelight::data {

std::vector<Shot> shotsOfScene(Spec& spec, const CameraContext& context) {
  const std::vector<scene::Camera>& cameras = context.scene.cameras;
  if (cameras.empty()) badUsage("{}: {} has no cameras of its own", spec.path(), context.scene.source);
  const std::vector<std::string> chosen = spec.has("names") ? spec.texts("names") : std::vector<std::string>();
  uint64_t names = 0;
  for (const scene::Camera& camera : cameras) names += chosen.empty() ? camera.name.size() : 0;
  for (const std::string& name : chosen) names += name.size();
  context.claim(spec, chosen.empty() ? cameras.size() : chosen.size(), names);
  std::vector<Shot> shots;
  if (chosen.empty()) {
    for (const scene::Camera& camera : cameras) shots.push_back(toShot(camera, context.scene));
    return shots;
  }
  for (const std::string& name : chosen) {
    const auto camera = std::ranges::find(cameras, name, &scene::Camera::name);
    if (camera == cameras.end())
      badUsage("{}: {} has no camera \"{}\"", spec.pathOf("names"), context.scene.source, name);
    shots.push_back(toShot(*camera, context.scene));
  }
  return shots;
}

}  // namespace latelight::data
