// The times that `latelight render` shows: one moment, or the frames of a sequence; and how the camera turns.
#pragma once

#include <optional>

#include "app/render_options.h"
#include "render/submit/renderer.h"
#include "scene/animation.h"
#include "scene/scene.h"

namespace latelight::app {

// Throws Error(Usage) for errors that can be found before the scene is loaded.
void checkTime(const RenderOptions& options);

class Timeline {
 public:
  // Throws Error(Usage) for an animation that the scene doesn't have.
  Timeline(const scene::Scene& scene, const RenderOptions& options);

  bool isSequence() const { return sequence_; }
  uint32_t first() const { return first_; }
  uint32_t last() const { return last_; }
  uint32_t frameDigits() const;
  std::optional<double> secondsAt(uint32_t frame) const;  // nothing: the scene at rest

  // The camera of a frame, and where everything is, including the previous and the next frame.
  scene::Camera cameraAt(uint32_t frame) const;
  render::Moment momentAt(uint32_t frame) const;

 private:
  scene::Pose poseAt(double seconds) const;
  scene::Camera cameraAt(double seconds) const;

  const scene::Scene& scene_;
  const RenderOptions& options_;
  scene::Playback playback_;
  glm::dvec3 pivot_;  // the centre of --turn, world space
  bool sequence_ = false, still_ = false;
  uint32_t first_ = 0, last_ = 0;
};

}  // namespace latelight::app
