// The cameras of a job in one scene: when each sees the scene, and the frames before and after it, which the output
// motion leads to.
//
// The poses of an ordered source (path, orbit, TUM, transforms, COLMAP, BOP; also below stereo and rig) are a sequence:
// the neighbors of a frame are the frames of the neighboring poses, and the first and the last frame lack one. All
// other cameras have no neighbors in a scene at rest; at a time of the scene, their neighbors are the same camera 1 /
// fps seconds earlier and later, which are no frames of the set.
#pragma once

#include <cstdint>
#include <array>
#include <optional>
#include <vector>

#include "base/memory.h"
#include "data/batch/job.h"
#include "data/cameras/cameras.h"
#include "render/deform/deformer.h"

namespace latelight::data {

class CameraTimeline {
 public:
  // Throws Error as makeCameras() does, and for an animation that the scene does not have.
  CameraTimeline(const Job& job, const scene::Scene& scene);

  size_t size() const { return cameras_.size(); }
  const JobCamera& camera(size_t i) const { return cameras_[i]; }  // with the size of its pictures
  // Seconds; none: the scene is at rest.
  std::optional<double> time(size_t i) const;

  struct Neighbor {
    const scene::Camera& camera;
    std::optional<double> time;
    std::optional<size_t> place;  // among the cameras; none: the set does not have that frame
  };
  std::optional<Neighbor> previous(size_t i) const;
  std::optional<Neighbor> next(size_t i) const;

  // The scene's moving parts in the frame before, the frame itself, and the frame after.
  render::Poses poses(size_t i) const;
  // Frames with the same number have the same poses, and may be rendered at once.
  uint64_t momentOf(size_t i) const;

 private:
  struct Times {
    std::optional<double> previous, now, next;
  };
  Times timesOf(size_t i) const;
  std::optional<Neighbor> inSequence(size_t i, std::optional<size_t> neighbor) const;

  const Job& job_;
  const scene::Scene& scene_;
  scene::Playback playback_;
  std::array<MemoryClaim, 3> memory_;  // of the cameras
  std::vector<JobCamera> cameras_;
  std::vector<JobCamera> earlier_, later_;  // 1 / fps seconds; empty where the scene moves no camera
};

}  // namespace latelight::data
