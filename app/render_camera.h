// The camera of `latelight render`.
#pragma once

#include "app/render_options.h"
#include "scene/scene.h"

namespace latelight::app {

// Returns the camera of --camera, --eye or --orbit; by default the scene's first camera, or one that shows the whole
// scene. `cameras` are the scene's, posed at the image's time. Throws Error(Usage).
scene::Camera chooseCamera(const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                           const RenderOptions& options);

}  // namespace latelight::app
