// Reference motion vectors, computed on the CPU in double precision from only the scene, its poses and its cameras. The
// ray through each pixel center is intersected with every triangle.
#pragma once

#include <vector>

#include "render/submit/renderer.h"
#include "scene/scene.h"

namespace latelight::render::test {

struct ReferencePixel {
  double depth = 0;                    // along the view axis; 0: background
  glm::dvec2 backward{0}, forward{0};  // in pixels, y down
};

std::vector<ReferencePixel> referenceMotion(const scene::Scene& scene, const SceneState& moment,
                                            const scene::Camera& camera, uint32_t width, uint32_t height);

// The vertices of an instance's mesh in a pose, in world space.
std::vector<glm::dvec3> worldVertices(const scene::Scene& scene, size_t instance, const scene::Pose& pose);

// Projects a world-space position to pixel coordinates, y down.
glm::dvec2 pixelOf(const scene::Camera& camera, uint32_t width, uint32_t height, glm::dvec3 world);

}  // namespace latelight::render::test
