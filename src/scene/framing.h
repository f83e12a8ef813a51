// Cameras without manual placement: a default view of a scene, an orbit around it, and a view from one point to
// another.
//
// "The file's own frame" is glTF's (Y up, front +Z) if Scene::yUp, otherwise the renderer's (Z up, front -Y). Angles
// are in radians, lengths in meters. Every camera is perspective with an infinite far plane, and its near plane is so
// close that it clips nothing, wherever the scene and the camera move. Reversed depth in floats has the same relative
// precision for any near plane.
#pragma once

#include <optional>

#include "scene/scene.h"

namespace latelight::scene {

inline constexpr float kDefaultVerticalFov = 0.7f;  // full angle; about 40 degrees

// Valid full vertical angles: 1e-7 to 179.999 degrees. Outside this range, the tangent in floats is inaccurate or even
// NaN.
inline constexpr float kMinVerticalFov = 1.74532925e-9f, kMaxVerticalFov = 3.14157520f;
inline bool isUsableFieldOfView(float verticalFov) {
  return verticalFov >= kMinVerticalFov && verticalFov <= kMaxVerticalFov;
}

// Returns the multiple, at least 1, of its own vertical extent that a camera shows in an image of this aspect (width /
// height), so that the image contains the camera's full frame. It scales the half height of orthographic cameras, and
// the tangent of half the field of view of perspective ones.
float verticalScale(const Camera& camera, float aspect);

// Returns the view of a scene without a camera: three-quarter, from the front, the right and slightly above. All eight
// corners of the scene's bounds are inside an image of this aspect (width / height) with a small margin. Supports any
// scene: empty, flat, a single point, and sizes from 1e-15 to 1e15 m.
Camera frameScene(const Scene& scene, float aspect);

// Returns a camera on a sphere around the center of the scene's bounds, looking at it. Azimuth 0 is in front of the
// scene (glTF's +Z) and increases towards the right (+X). Elevation increases upwards, and at +-pi/2 the image's up
// direction points away from the azimuth. Without a distance, the bounding sphere fits an image of this aspect at any
// angle, so that the scale of a turntable stays constant. Throws Error(Usage) for angles that aren't finite, a distance
// that isn't positive, or an invalid field of view.
Camera orbitCamera(const Scene& scene, float azimuth, float elevation, std::optional<float> distance = {},
                   float verticalFov = kDefaultVerticalFov, float aspect = 1);

// Returns a camera at `eye` that looks at `target`, both in the file's own frame. Without `up`, the file's up is used,
// or the direction away from the file's front if up is the viewing direction. Throws Error(Usage) if eye and target are
// equal or not finite, `up` is zero or parallel to the view, or the field of view is invalid.
Camera lookAt(const Scene& scene, dvec3 eye, dvec3 target, std::optional<dvec3> up = {},
              float verticalFov = kDefaultVerticalFov);

}  // namespace latelight::scene
