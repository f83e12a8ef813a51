// Converts cameras to the View that shaders read.
#pragma once

#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

// A camera's view of `width` by `height` pixels: reversed depth (infinite where the camera has no far plane), square
// pixels, the camera's vertical extent kept. `jitter`: offset of the sample from the pixel's centre, pixels, y down.
shared::View makeView(const scene::Camera& camera, uint32_t width, uint32_t height, glm::vec2 jitter = glm::vec2(0));

}  // namespace latelight::render
