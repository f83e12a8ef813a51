// Converts cameras to the View that shaders read.
#pragma once

#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

// Returns true if a camera's lens bends rays: its images are not planar projections, unlike those of a pinhole.
inline bool bendsRays(const scene::Camera& camera) {
  return camera.lens && camera.lens->model != scene::LensModel::Pinhole;
}

// Returns a camera's view of `width` by `height` pixels, with reversed depth (infinite if the camera has no far plane)
// and square pixels. The view shows the camera's whole frame (Camera::aspect) or, if it has none, its vertical extent.
// A pinhole lens replaces both. For any other lens, the view is only a pose: its rays do not follow a projection
// (render/lens), and its depth, measured along them, ignores the near and far planes. `jitter`: offset of the sample
// from the pixel's center, in pixels, y down. `origin`: the origin of the device's world space in the scene's
// (GpuScene::origin()).
shared::View makeView(const scene::Camera& camera, uint32_t width, uint32_t height, glm::vec2 jitter = glm::vec2(0),
                      const glm::dvec3& origin = glm::dvec3(0));

// Returns the camera's rotation and position: its transform without scale.
glm::dmat4 rigidPose(const scene::Camera& camera);

// Returns the rotation from OpenCV's camera axes (X right, Y down, Z forward) to view space.
glm::dmat4 viewFromOpenCv();

// Sets the eye as a float and the remainder of the double.
void placeEye(shared::View& view, const glm::dvec3& eye);

}  // namespace latelight::render
