// Depth of field by a thin lens: a point of the aperture sees the scene from that point, through an image plane that is
// sheared so that the plane in focus stays where it is (Potmesil and Chakravarty 1981, A Lens and Aperture Camera Model
// for Synthetic Image Generation; Haeberli and Akeley 1990). The mean over the aperture blurs a point at the depth y to
// the shape of the aperture with the radius |1 / focus - 1 / y| radius in units of the focal length: the circle of
// confusion.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "render/gpu_scene/worlds.h"
#include "render/settings/settings.h"
#include "scene/scene.h"
#include "shared/types.h"

namespace latelight::render {

struct ThinLens {
  double radius = 0;  // meters; 0: a pinhole
  double focus = 1;   // meters from the lens to the plane in focus, along the axis
  bool operator==(const ThinLens&) const = default;
};

// Returns the lens of a camera for pictures of the settings' size. The focal length of an f-number is that of a sensor
// of Settings::sensorHeight with the picture's vertical field of view. By default, the focus is at the center of the
// scene at rest. Throws Error(Usage) for an orthographic camera or a panorama with an aperture.
ThinLens thinLensOf(const scene::Camera& camera, const Settings& settings, const scene::Scene& scene);
// The same for the cameras of a call. By default, they focus on the center of their own world at rest. The host has the
// lists of worlds if a camera has an aperture.
std::vector<ThinLens> thinLensesOf(std::span<const scene::Camera> cameras, const Settings& settings,
                                   const scene::Scene& scene, const WorldStates& worlds);

// Moves a camera to a point of its aperture, right and up in meters.
scene::Camera atAperture(const scene::Camera& camera, glm::dvec2 offset);
// Shears the view of such a camera, which makeView() returned, so that the plane at `focus` meters stays in place.
void focusView(shared::View& view, glm::dvec2 offset, double focus);

}  // namespace latelight::render
