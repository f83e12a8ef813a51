// The path of a sensor that is mounted on a camera of a job, and its scans along the path.
#pragma once

#include <vector>

#include "data/batch/camera_timeline.h"
#include "data/scans.h"

namespace latelight::data {

// The path of a camera from its frame through the following frames of its sequence. Between two frames, the position
// changes linearly, and the camera rotates about a fixed axis at constant speed. After the last frame the motion
// continues. A camera whose frames have no times does not move.
class CameraPath {
 public:
  struct Leg {
    double begin, seconds;  // begin: since the camera's frame
    const scene::Camera &from, &to;
  };

  CameraPath(const CameraTimeline& cameras, size_t camera, double seconds);
  const std::vector<Leg>& legs() const { return legs_; }  // empty: the camera does not move
  scene::Camera at(double seconds) const;

 private:
  const scene::Camera& camera_;
  std::vector<Leg> legs_;
};

// Scans from the pose of a camera's frame on. The scene moves, too, if it has a time.
FrameScan scanFrom(render::Renderer& renderer, const scene::Scene& scene, const CameraTimeline& cameras, size_t camera,
                   const render::Settings& settings, const std::shared_ptr<const ScanRequest>& request, uint64_t seed);

}  // namespace latelight::data
