// Which camera `latelight render` looks through.
#pragma once

#include "app/render_options.h"
#include "scene/scene.h"

namespace latelight::app {

// By --camera, --eye, --orbit, or the scene's first, or one that shows all of it. Throws Error(Usage).
scene::Camera chooseCamera(const scene::Scene& scene, const RenderOptions& options);

}  // namespace latelight::app
