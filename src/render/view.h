// Converts cameras to the View that shaders read.
#pragma once

#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

// Whether a camera's lens makes pictures that no plane has, unlike a pinhole's.
inline bool bendsRays(const scene::Camera& camera) {
  return camera.lens && camera.lens->model != scene::LensModel::Pinhole;
}

// A camera's view of `width` by `height` pixels: reversed depth (infinite where the camera has no far plane) and square
// pixels. The view shows the camera's whole frame (Camera::aspect), or has its vertical extent where the camera has no
// frame; a pinhole lens replaces both. A view through another lens is a pose: its depth, along rays that no projection
// has (render/lens), has no planes. `jitter`: offset of the sample from the
// pixel's center, pixels, y down. `origin`: of the device's world space in the scene's (GpuScene::origin()).
shared::View makeView(const scene::Camera& camera, uint32_t width, uint32_t height, glm::vec2 jitter = glm::vec2(0),
                      const glm::dvec3& origin = glm::dvec3(0));

// The camera's rotation and position: its transform without scale.
glm::dmat4 rigidPose(const scene::Camera& camera);

// Sets the eye: a float and the rest of the double that it rounds.
void placeEye(shared::View& view, const glm::dvec3& eye);

}  // namespace latelight::render
