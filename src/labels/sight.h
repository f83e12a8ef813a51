// Lines of sight from a camera to points of the scene, by ray casting.
#pragma once

#include <glm/geometric.hpp>
#include <span>
#include <vector>

#include "render/submit/renderer.h"

namespace latelight::labels {

// The line of sight from a camera to a point.
struct Sight {
  double distance = 0;   // from the camera to the point; for an orthographic camera from its plane; meters
  double hit = 0;        // to the first surface before the point; +inf if there is none
  uint32_t id = 0;       // of that surface's object
  bool clipped = false;  // the point is before the camera's near plane or beyond its far plane, so it is not visible
};

// `points` are in the frame of settings.axes. `moment` poses the scene. A surface that the point itself lies on is not
// before it, for which `slack` is the share of the distance that rounding may take.
std::vector<Sight> sightsOf(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                            const render::Settings& settings, const render::SceneState& moment,
                            std::span<const glm::dvec3> points, double slack);

// The part of a line of sight from the camera's near plane up to a point, which is at origin + direction. In the frame
// of the settings' axes. If the point is clipped, the segment begins at the camera.
struct SightSegment {
  glm::dvec3 origin, direction;
  double start = 0;  // the distance of the origin from the camera, for an orthographic camera from its plane; meters
  bool clipped = false;

  // Returns true if a surface at this distance from the origin is not before the point.
  bool isFreeUpTo(double hit, double slack) const { return start + hit >= distance() * (1 - slack); }
  double distance() const { return start + glm::length(direction); }  // of the point from the camera
};
SightSegment sightSegment(const glm::dvec3& point, const scene::Camera& camera, const scene::Scene& scene, bool zUp);

// The same for lines of sight from several cameras.
std::vector<Sight> sightsOf(render::Renderer& renderer, std::span<const SightSegment> segments,
                            const render::Settings& settings, const render::SceneState& moment, double slack);

// A point and the camera that looks at it, which shows a world.
struct SightLine {
  const scene::Camera* camera;
  glm::dvec3 point;  // as above
};
// The same in the worlds of `moment`, which have no bounding volume hierarchy. Each line is an image of one pixel, with
// the line through its center.
std::vector<Sight> sightsOfWorlds(render::Renderer& renderer, const scene::Scene& scene,
                                  std::span<const SightLine> lines, const render::Settings& settings,
                                  const render::SceneState& moment, double slack);

}  // namespace latelight::labels
