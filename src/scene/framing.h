// Cameras without manual placement: a default view of a scene, an orbit around it, and a look from one point to
// another.
//
// "The file's own frame" is glTF's (Y up, front +Z) where Scene::yUp, else the renderer's (Z up, front -Y). Angles in
// radians, lengths in metres. Every camera is a perspective one with an infinite far plane, and a near plane so near
// that it clips nothing, wherever the scene and the camera move: reversed depth in floats has the same relative
// precision at any near plane.
#pragma once

#include <optional>

#include "scene/scene.h"

namespace latelight::scene {

inline constexpr float kDefaultVerticalFov = 0.7f;  // full angle; about 40 degrees

// Valid full vertical angles: 1e-7 to 179.999 degrees. Beyond, the tangent in floats is inaccurate, and in the end not
// a number.
inline constexpr float kLeastVerticalFov = 1.74532925e-9f, kMostVerticalFov = 3.14157520f;
inline bool showsSomething(float verticalFov) {
  return verticalFov >= kLeastVerticalFov && verticalFov <= kMostVerticalFov;
}

// How many times its own vertical extent a camera shows in a picture of this aspect (width / height), so that the
// camera's whole frame is in it: at least 1. It scales the half height of orthographic cameras, and the tangent of half
// the field of view of perspective ones.
float verticalScale(const Camera& camera, float aspect);

// The view where a scene has no camera: three-quarter, from the front, the right and slightly above, all eight corners
// of the scene's bounds inside a picture of this aspect (width / height) with a small margin. Works for any scene:
// empty, flat, a single point, and sizes from 1e-15 to 1e15 m.
Camera frameScene(const Scene& scene, float aspect);

// A camera on a sphere around the centre of the scene's bounds, looking at it. Azimuth 0 is in front of the scene
// (glTF's +Z) and grows towards the right (+X); elevation grows upwards, and at +-pi/2 the picture's up is away from
// azimuth. Without a distance, the bounding sphere fits a picture of this aspect at any angles, so that the scale of a
// turntable stays constant. Throws Error(Usage) for angles that aren't finite, a distance that isn't positive and an
// invalid field of view.
Camera orbitCamera(const Scene& scene, float azimuth, float elevation, std::optional<float> distance = {},
                   float verticalFov = kDefaultVerticalFov, float aspect = 1);

// A camera at `eye` that looks at `target`, both in the file's own frame; without `up`, the file's up is up, and where
// that is the viewing direction, away from the file's front. Throws Error(Usage) where eye and target are the same or
// not finite, `up` is zero or along the view, or the field of view is invalid.
Camera lookAt(const Scene& scene, dvec3 eye, dvec3 target, std::optional<dvec3> up = {},
              float verticalFov = kDefaultVerticalFov);

}  // namespace latelight::scene
