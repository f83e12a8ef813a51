// Shared by the command line, the API and viewers: the choice of a scene's environment, what a debug picture takes, and
// camera poses in external frames.
#pragma once

#include <optional>
#include <string>

#include "output/debug_request.h"
#include "render/moment.h"
#include "render/settings.h"
#include "scene/environment.h"
#include "scene/scene.h"

namespace latelight::render {

// The environment to load: `asked` (a file, "studio" or "none"). Where nothing was asked for, the scene's own; else the
// studio for a scene without any light, so that no first picture is black, and where it is to be seen behind it.
// Empty: none.
std::string environmentName(const scene::Scene& scene, const std::string& asked, bool isSeen);
// Nothing for an empty name.
std::optional<scene::Environment> loadEnvironment(const scene::Scene& scene, const std::string& name);

// Asks for what --debug's picture is made of. Throws Error(Usage) for a target that the layout does not have.
void showDebug(Settings& settings, const output::DebugRequest& debug);

// Where everything is at the settings' time, and a frame before and after; at rest without one.
Poses posesAt(const scene::Scene& scene, const Settings& settings);

// The camera as --camera-fit shows it: without a frame of its own where pictures keep its vertical field of view.
inline scene::Camera fitted(scene::Camera camera, CameraFit fit) {
  if (fit == CameraFit::Vertical) camera.aspect.reset();
  return camera;
}

// OpenCV's camera frame (X right, Y down, Z forward) to the scene file's frame (or the renderer's world if `zUp`).
glm::dmat4 openCvPose(const scene::Camera& camera, const scene::Scene& scene, bool zUp);
// The inverse: the camera's toWorld from such a pose in the scene file's frame.
glm::dmat4 toWorldFromOpenCv(const glm::dmat4& pose, const scene::Scene& scene);

}  // namespace latelight::render
