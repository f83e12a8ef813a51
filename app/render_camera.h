// The camera of `latelight render`.
#pragma once

#include "app/render_options.h"
#include "scene/scene.h"

namespace latelight::app {

// From --camera, --eye, --orbit, or the scene's first, or one that shows the whole scene. Throws Error(Usage).
// `cameras`: the scene's, posed at the picture's time.
scene::Camera chooseCamera(const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                           const RenderOptions& options);

}  // namespace latelight::app
