// A camera that people steer: around a point (a turntable, as in Blender and the Khronos viewer) or flying. Plain
// mathematics in the renderer's world (X right, Y away, Z up), the same for scenes of any size.
#pragma once

#include <glm/glm.hpp>

namespace latelight::view {

// Up is always up. `target` is what it turns about; it lies on the view axis.
struct Viewpoint {
  glm::dvec3 eye{0, -1, 0}, target{0};
  double verticalFov = 0.7;  // full angle, radians
  bool operator==(const Viewpoint&) const = default;
};

// Unit axes of its picture.
struct ViewAxes {
  glm::dvec3 right, away, up;
};
ViewAxes axesOf(const Viewpoint& view);

// A place in a picture, and a way within it: in heights of the picture, from its centre, x to the right and y down.
using PicturePoint = glm::dvec2;

// From the eye, so that what lies a metre along the view axis comes out a metre away along it.
glm::dvec3 rayThrough(const Viewpoint& view, PicturePoint point);

class CameraControl {
 public:
  // `size`: the scene's radius, which flying speed and the nearest distance are in proportion to.
  CameraControl(const Viewpoint& view, double size);

  const Viewpoint& view() const { return view_; }
  double speed() const { return speed_; }  // of flying, metres a second

  // Turns the scene by the drag: a picture's height is half a turn. The eye keeps its distance to the target.
  void orbit(PicturePoint drag);
  // Turns the head towards where the pointer goes; a picture's height is the field of view.
  void look(PicturePoint drag);
  // Moves across the view: what lies at the target's distance follows the pointer.
  void pan(PicturePoint drag);
  // Scales the way to `towards` by 0.9 a step: that point stays where it is in the picture.
  void dolly(double steps, glm::dvec3 towards);
  // Along right, away and up (of the world), at the speed of flying.
  void fly(glm::dvec3 direction, double seconds);
  void changeSpeed(double steps);  // by a fifth each
  // Looks along this direction at the target, from the same distance: azimuth 0 is the scene's front, as in --orbit.
  void turnTo(double azimuth, double elevation);
  // The closest place from which a ball is inside a picture of this aspect (width / height), seen in the same
  // direction.
  void frame(glm::dvec3 centre, double radius, double aspect);

 private:
  void place(double azimuth, double elevation, double distance);
  double least() const { return 1e-6 * size_; }  // distance between eye and target

  Viewpoint view_;
  double size_, speed_;
};

}  // namespace latelight::view
