// Interactive camera control: orbiting around a point (turntable, as in Blender and the Khronos viewer) and flying. It
// is plain mathematics in the renderer's world (X right, Y forward, Z up), and scales with the size of the scene.
#pragma once

#include <glm/glm.hpp>

namespace latelight::view {

// A camera without roll. `target` is the orbit center; it lies on the view axis.
struct Viewpoint {
  glm::dvec3 eye{0, -1, 0}, target{0};
  double verticalFov = 0.7;  // full angle, radians
  bool operator==(const Viewpoint&) const = default;
};

// Unit axes of the view: right, forward (away from the viewer) and up.
struct ViewAxes {
  glm::dvec3 right, away, up;
};
ViewAxes axesOf(const Viewpoint& view);

// A position or a displacement in the picture, in units of the picture's height, relative to the center, x right and y
// down.
using PicturePoint = glm::dvec2;

// Returns the ray from the eye through a point. Its component along the view axis is 1 m.
glm::dvec3 rayThrough(const Viewpoint& view, PicturePoint point);

class CameraControl {
 public:
  // `size`: the scene's radius. Flying speed and minimum distance are proportional to it.
  CameraControl(const Viewpoint& view, double size);

  const Viewpoint& view() const { return view_; }
  double speed() const { return speed_; }  // of flying, in meters per second

  // Orbits by the drag; a drag over the picture's height is half a turn. The distance to the target does not change.
  void orbit(PicturePoint drag);
  // Rotates the view direction with the pointer; a drag over the picture's height is the vertical field of view.
  void look(PicturePoint drag);
  // Moves the camera parallel to the picture plane: points at the target's distance follow the pointer.
  void pan(PicturePoint drag);
  // Scales the distance to `towards` by 0.9 per step; that point keeps its position in the picture.
  void dolly(double steps, glm::dvec3 towards);
  // Moves along the right and forward axes and the world's up axis, at speed().
  void fly(glm::dvec3 direction, double seconds);
  void changeSpeed(double steps);  // by a fifth per step
  // Views the target from this direction, at the same distance: azimuth 0 is the scene's front, as in --orbit.
  void turnTo(double azimuth, double elevation);
  // Moves to the closest position from which a sphere fits into a picture of this aspect (width / height), without a
  // change of direction.
  void frame(glm::dvec3 center, double radius, double aspect);

 private:
  void place(double azimuth, double elevation, double distance);
  double least() const { return 1e-6 * size_; }  // minimum distance between eye and target

  Viewpoint view_;
  double size_, speed_;
};

}  // namespace latelight::view
