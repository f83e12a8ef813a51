// The times that `latelight render` shows: one time or the frames of a sequence, and the rotation of the camera.
#pragma once

#include <optional>

#include "app/render_options.h"
#include "render/submit/renderer.h"
#include "scene/animation.h"
#include "scene/scene.h"

namespace latelight::app {

// Throws Error(Usage) for errors that can be detected before the scene is loaded.
void checkTime(const RenderOptions& options);

class Timeline {
 public:
  // Throws Error(Usage) for an animation that the scene does not have.
  Timeline(const scene::Scene& scene, const RenderOptions& options);

  bool isSequence() const { return sequence_; }
  uint32_t first() const { return first_; }
  uint32_t last() const { return last_; }
  uint32_t frameDigits() const;
  std::optional<double> secondsAt(uint32_t frame) const;  // empty: the scene at rest

  // cameraAt() returns the camera of a frame, and momentAt() the scene state, including the previous and the next
  // frame.
  scene::Camera cameraAt(uint32_t frame) const;
  render::SceneState momentAt(uint32_t frame) const;

  // The second picture of --correspond: its camera, and the scene's pose at its time.
  struct SecondPicture {
    scene::Camera camera;
    scene::Pose pose;
  };
  SecondPicture secondPicture(uint32_t frame) const;

 private:
  scene::Pose poseAt(double seconds) const;
  scene::Camera cameraAt(double seconds, const RenderOptions& options) const;
  scene::Camera cameraAt(double seconds) const { return cameraAt(seconds, options_); }

  const scene::Scene& scene_;
  const RenderOptions& options_;
  scene::Playback playback_;
  glm::dvec3 pivot_;  // the center of --turn, world space
  bool sequence_ = false, still_ = false;
  uint32_t first_ = 0, last_ = 0;
};

}  // namespace latelight::app
