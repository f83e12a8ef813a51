// Where cameras are at times near that of their picture: between the frames of a sequence.
#pragma once

#include <functional>
#include <vector>

#include "render/settings/settings.h"
#include "scene/animation.h"
#include "scene/scene.h"

namespace latelight::render {

// How the scene and its cameras move near a picture's time, for pictures that take time. Times are offsets in seconds
// from that of the picture. The functions live as long as the picture's tickets.
struct SceneMotion {
  std::function<scene::Pose(double seconds)> poseAt;  // null: the scene does not move
  // Null: each camera moves between the previous, the current and the next frame, as between() does.
  std::function<scene::Camera(size_t camera, double seconds)> cameraAt;
  // Seconds between the current frame and the others, per camera; 0: the sequence has no such frame. Empty: all are a
  // frame of Settings::framesPerSecond.
  std::vector<double> sincePrevious, untilNext;
};

// Returns the pose at a share of the way from one rigid pose to another, or beyond them: the position changes linearly,
// and the rotation is about a fixed axis at constant speed.
glm::dmat4 poseBetween(const glm::dmat4& from, const glm::dmat4& to, double share);

// Returns the camera at a share of the way from `a` to `b`, or beyond them. The pose is that of poseBetween(). In
// pictures of `width` x `height` pixels, the focal lengths and the principal point of perspective cameras without a
// lens that bends rays change linearly, however the cameras describe them, and so do the extents of orthographic
// cameras. All else is that of `a`.
scene::Camera between(const scene::Camera& a, const scene::Camera& b, double share, uint32_t width, uint32_t height);

class CameraMotion {
 public:
  // `previous` and `next`: one per camera, or empty if the cameras are static. `settings`: the pictures' size and the
  // frames per second.
  CameraMotion(std::vector<scene::Camera> now, std::vector<scene::Camera> previous, std::vector<scene::Camera> next,
               SceneMotion motion, const Settings& settings);

  // Without a previous frame, the camera moves as it does until the next one, and vice versa.
  scene::Camera at(size_t camera, double seconds) const;
  bool movesCameras() const;
  bool movesScene() const { return motion_.poseAt != nullptr; }
  scene::Pose poseAt(double seconds) const { return motion_.poseAt(seconds); }
  size_t count() const { return now_.size(); }

 private:
  std::vector<scene::Camera> now_, previous_, next_;
  SceneMotion motion_;
  uint32_t width_, height_;  // of the pictures
  double frameSeconds_;
};

}  // namespace latelight::render
