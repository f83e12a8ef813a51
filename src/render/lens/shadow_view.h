// The view that the shadow maps of a picture are planned for.
#pragma once

#include "render/gpu_scene.h"
#include "shared/types.h"

namespace latelight::render {

// The camera's own. Through a lens a pinhole view around all that it sees, or where there is none, an orthographic one
// of the whole scene.
shared::View shadowView(const scene::Camera& camera, uint32_t width, uint32_t height, const GpuScene& scene);

}  // namespace latelight::render
