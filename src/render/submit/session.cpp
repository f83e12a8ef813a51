#include "render/submit/session.h"

#include <algorithm>

#include "base/error.h"
#include "base/text.h"
#include "render/frame/view.h"
#include "render/gbuffer/layout.h"
#include "scene/file_frame.h"

namespace latelight::render {

std::string environmentName(const scene::Scene& scene, const std::string& asked, bool isSeen) {
  if (asked == "none") return "";
  if (!asked.empty()) return asked;
  if (scene.environment) return scene.environment->name;
  return isSeen || std::ranges::all_of(scene.lights, &scene::Light::removed) ? "studio" : "";
}

std::optional<scene::Environment> loadEnvironment(const scene::Scene& scene, const std::string& name) {
  if (name.empty()) return std::nullopt;
  if (scene.environment && scene.environment->name == name) return *scene.environment;
  return scene::loadEnvironment(name);
}

void showDebug(Settings& s, const output::DebugRequest& debug) {
  s.aovs = debug.aovs;
  s.display = output::contains(debug.aovs, output::Aov::Color);
  if (!debug.targets && !output::contains(s.aovs, output::Aov::Id))
    s.aovs.push_back(output::Aov::Id);  // identifies the background
  if (debug.target.empty()) return;
  if (!s.layout->hasTargets()) return;  // Renderer::readTargets() reports this
  std::vector<std::string> names;
  for (const LayoutTarget& target : s.layout->targets) names.emplace_back(target.name);
  if (std::ranges::find(names, debug.target) == names.end())
    badUsage("--debug target: the layout {} has no target \"{}\"; it has {}", s.layout->name, debug.target,
             joinedByOr(names));
}

Poses posesAt(const scene::Scene& scene, const Settings& settings) {
  if (!settings.time) return {};
  const scene::Playback playback = scene::choosePlayback(scene, settings.animation, settings.loop);
  const double step = 1 / settings.framesPerSecond;
  return {scene::poseAt(scene, playback, *settings.time - step), scene::poseAt(scene, playback, *settings.time),
          scene::poseAt(scene, playback, *settings.time + step)};
}

SceneMotion motionNear(const scene::Scene& scene, const Settings& settings) {
  if (!settings.time || !scene.rig.isAnimated()) return {};
  const scene::Playback playback = scene::choosePlayback(scene, settings.animation, settings.loop);
  return {.poseAt = [&scene, playback, time = *settings.time](double seconds) {
    return scene::poseAt(scene, playback, time + seconds);
  }};
}

SceneState onlyReadout(const SceneState& moment, const Settings& settings) {
  if (settings.readout == 0) return {.poses = moment.poses, .worlds = moment.worlds};
  return {.poses = moment.poses,
          .previousCameras = moment.previousCameras,
          .nextCameras = moment.nextCameras,
          .motion = moment.motion};
}

glm::dmat4 openCvPose(const scene::Camera& camera, const scene::Scene& scene, bool zUp) {
  glm::dmat4 pose = rigidPose(camera);
  if (scene.yUp && !zUp) pose = scene::toGltfFromWorld() * pose;
  return pose * viewFromOpenCv();
}

glm::dmat4 toWorldFromOpenCv(const glm::dmat4& pose, const scene::Scene& scene) {
  return scene::worldFromFile(scene) * pose *
         glm::transpose(viewFromOpenCv());  // a rotation: its transpose is its inverse
}

}  // namespace latelight::render
