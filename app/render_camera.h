// Which camera `latelight render` looks through.
#pragma once

#include "app/render_options.h"
#include "scene/scene.h"

namespace latelight::app {

// By --camera, --eye, --orbit, or the scene's first, or one that shows all of it. Throws Error(Usage). `cameras`: the
// scene's, where they are when the picture is made.
scene::Camera chooseCamera(const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                           const RenderOptions& options);

}  // namespace latelight::app
