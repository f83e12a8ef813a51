#include "labels/sight.h"

#include "render/submit/session.h"

namespace latelight::labels {

std::vector<Sight> sightsOf(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                            const render::Settings& settings, const render::SceneState& moment,
                            std::span<const glm::dvec3> points, double slack) {
  const glm::dmat4 pose = render::openCvPose(camera, scene, settings.axes == render::Axes::ZUp);
  const glm::dvec3 eye(pose[3]), axis(pose[2]);
  std::vector<glm::dvec3> origins(points.size(), eye), directions(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    if (camera.orthographic) origins[i] = points[i] - glm::dot(points[i] - eye, axis) * axis;
    directions[i] = points[i] - origins[i];
  }
  const render::CastHits hits = renderer.cast({.origins = origins, .directions = directions}, settings, moment).hits;
  std::vector<Sight> sights(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    Sight& sight = sights[i] = {glm::length(directions[i]), hits.distance[i], hits.id[i]};
    if (!(sight.hit < sight.distance * (1 - slack)))
      sight = {sight.distance, std::numeric_limits<double>::infinity(), 0};
  }
  return sights;
}

}  // namespace latelight::labels
