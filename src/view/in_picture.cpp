#include "view/in_picture.h"

#include <cmath>

#include "scene/framing.h"
#include "shared/light.h"

namespace latelight::view {

namespace {

// Returns half of the picture's extent, in meters per meter of depth, or in meters for orthographic cameras.
glm::dvec2 halfExtent(const scene::Camera& camera, glm::uvec2 size) {
  const double aspect = double(size.x) / size.y;
  const double own = camera.orthographic ? double{camera.yHalf} : std::tan(double{camera.verticalFov} / 2);
  const double half = own * scene::verticalScale(camera, static_cast<float>(aspect));
  return {half * aspect, half};
}

// Returns the coordinates along the camera's right, forward and up axes.
glm::dvec3 inView(const scene::Camera& camera, glm::dvec3 world) {
  const glm::dmat4& m = camera.toWorld;
  const glm::dvec3 way = world - glm::dvec3(m[3]);
  return {glm::dot(way, glm::dvec3(m[0])), glm::dot(way, glm::dvec3(m[1])), glm::dot(way, glm::dvec3(m[2]))};
}

}  // namespace

// Limits the state that is reported with each picture.
constexpr size_t kMaxLights = 1024;

std::vector<uint32_t> positionalLights(const scene::Scene& scene) {
  std::vector<uint32_t> lights;
  for (uint32_t i = 0; i < scene.lights.size(); ++i)
    if (!scene.lights[i].removed && scene.lights[i].type != shared::kLightDirectional && lights.size() < kMaxLights)
      lights.push_back(i);
  return lights;
}

std::optional<glm::dvec2> pixelOf(const scene::Camera& camera, glm::uvec2 size, glm::dvec3 world) {
  const glm::dvec3 v = inView(camera, world);
  if (!(v.y > 0)) return std::nullopt;
  const glm::dvec2 half = halfExtent(camera, size) * (camera.orthographic ? 1.0 : v.y);
  return glm::dvec2((v.x / half.x + 1) / 2 * size.x, (1 - v.z / half.y) / 2 * size.y);
}

std::optional<glm::dvec3> draggedTo(const scene::Camera& camera, glm::uvec2 size, glm::dvec3 from, glm::dvec2 pixel) {
  const glm::dvec3 v = inView(camera, from);
  if (!(v.y > 0)) return std::nullopt;
  const glm::dvec2 half = halfExtent(camera, size) * (camera.orthographic ? 1.0 : v.y);
  const glm::dvec2 to((2 * pixel.x / size.x - 1) * half.x, (1 - 2 * pixel.y / size.y) * half.y);
  return glm::dvec3(camera.toWorld * glm::dvec4(to.x, v.y, to.y, 1));
}

scene::Bounds boundsOf(const scene::Scene& scene, uint32_t id) {
  scene::Bounds bounds;
  for (const scene::Instance& instance : scene.instances) {
    if (instance.removed || instance.id != id) continue;
    const scene::Mesh& mesh = scene.meshes[instance.mesh];
    for (int corner = 0; corner < 8; ++corner) {
      const glm::vec3 at(corner & 1 ? mesh.boundsMax.x : mesh.boundsMin.x,
                         corner & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                         corner & 4 ? mesh.boundsMax.z : mesh.boundsMin.z);
      const glm::dvec3 world(instance.toWorld * glm::dvec4(at, 1));
      bounds.min = glm::min(bounds.min, world);
      bounds.max = glm::max(bounds.max, world);
    }
  }
  return bounds;
}

}  // namespace latelight::view
