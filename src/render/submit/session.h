// Functions that the command line, the API and viewers share: the choice of a scene's environment, the settings of a
// debug picture, and camera poses in external frames.
#pragma once

#include <optional>
#include <string>

#include "output/debug_request.h"
#include "render/settings/settings.h"
#include "render/submit/scene_state.h"
#include "scene/environment/environment.h"
#include "scene/scene.h"

namespace latelight::render {

// Returns the environment to load; empty: none. `asked`: a file, "studio" or "none". If it is empty, the result is the
// scene's own environment. A scene without one gets the studio if it has no light, so that no first picture is black,
// or if the environment is visible in the background (`isSeen`).
std::string environmentName(const scene::Scene& scene, const std::string& asked, bool isSeen);
// Returns nothing for an empty name.
std::optional<scene::Environment> loadEnvironment(const scene::Scene& scene, const std::string& name);

// Requests the outputs that make up --debug's picture. Throws Error(Usage) for a target that the layout does not have.
void showDebug(Settings& settings, const output::DebugRequest& debug);

// Returns the poses at the settings' time and one frame before and after; without a time, the scene is at rest.
Poses posesAt(const scene::Scene& scene, const Settings& settings);

// Returns how the scene moves near the settings' time. The result refers to the scene.
SceneMotion motionNear(const scene::Scene& scene, const Settings& settings);

// Returns the state in which data of the same picture are rendered again: its poses and worlds and, with a rolling
// shutter, its motion.
SceneState onlyReadout(const SceneState& moment, const Settings& settings);

// Returns the camera as --camera-fit defines it: without an aspect of its own if pictures keep its vertical field of
// view.
inline scene::Camera fitted(scene::Camera camera, CameraFit fit) {
  if (fit == CameraFit::Vertical) camera.aspect.reset();
  return camera;
}

// Returns the transform from OpenCV's camera frame (X right, Y down, Z forward) to the scene file's frame (or the
// renderer's world if `zUp`).
glm::dmat4 openCvPose(const scene::Camera& camera, const scene::Scene& scene, bool zUp);
// The inverse: returns the camera's toWorld for such a pose in the scene file's frame.
glm::dmat4 toWorldFromOpenCv(const glm::dmat4& pose, const scene::Scene& scene);

}  // namespace latelight::render
