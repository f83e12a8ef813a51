// The view for which a picture's shadow maps are planned.
#pragma once

#include "render/gpu_scene/gpu_scene.h"
#include "shared/types.h"

namespace latelight::render {

// Returns the camera's own view. For a lens that bends rays, returns a pinhole view that encloses all rays or, if there
// is none, an orthographic view of the whole scene.
shared::View shadowView(const scene::Camera& camera, uint32_t width, uint32_t height, const GpuScene& scene);

}  // namespace latelight::render
