// The cameras of a job in one scene: the scene time of each camera's frame, and the previous and next frames that its
// motion vectors (output `motion`) refer to.
//
// The poses of an ordered source (path, orbit, TUM, transforms, COLMAP, BOP; also inside stereo and rig) are a
// sequence: the neighbors of a frame are the frames of the neighboring poses. The first frame has no previous one, and
// the last frame has no next one. All other cameras have no neighbors in a scene at rest. In a scene with a time, their
// neighbors are the same camera 1 / fps seconds earlier and later, which are not frames of the set.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "base/memory.h"
#include "data/batch/job.h"
#include "data/cameras/cameras.h"
#include "data/pairs.h"
#include "render/deform/deformer.h"

namespace latelight::data {

class CameraTimeline {
 public:
  // Throws Error as makeCameras() does, and if the scene does not have the job's animation.
  CameraTimeline(const Job& job, const scene::Scene& scene);

  // Moves the cameras that follow cameras of the scene to the places of nodes that a variation has moved. Animations no
  // longer move them then. Cameras of other nodes return to their places. `movedNodes`: transforms in the world.
  void follow(const std::map<uint32_t, scene::dmat4>& movedNodes);

  size_t size() const { return cameras_.size(); }
  const JobCamera& camera(size_t i) const { return cameras_[i]; }  // its picture size is set
  // Scene time in seconds; empty if the scene is at rest.
  std::optional<double> time(size_t i) const;

  struct Neighbor {
    const scene::Camera& camera;
    std::optional<double> time;
    std::optional<size_t> place;  // index of its camera; empty if the set does not contain that frame
  };
  std::optional<Neighbor> previous(size_t i) const;
  std::optional<Neighbor> next(size_t i) const;

  // Returns the second image of a pair; empty if there is none, or if it is the frame itself. Throws Error(Usage) if
  // the scene has no camera of the target's name.
  std::optional<Neighbor> target(size_t i, const PairTarget& target) const;
  scene::Pose poseAt(const std::optional<double>& time) const;  // of the scene's moving parts; empty: at rest

  // Returns the seconds from a camera's frame to its neighbor's or back; empty if neither the job nor the source of the
  // cameras has times.
  std::optional<double> secondsTo(size_t i, const Neighbor& neighbor) const;

  // Returns the poses at offsets in seconds from a frame's time; null if nothing moves.
  std::function<scene::Pose(double)> posesNear(size_t i) const;
  // The poses of the scene's moving parts in the previous frame, in the frame itself, and in the next frame.
  render::Poses poses(size_t i) const;
  // The job's settings with the exposure of a camera.
  render::Settings settingsOf(size_t i) const;
  // Frames with the same number have the same poses and exposure, and may be rendered together.
  uint64_t momentOf(size_t i) const;

 private:
  struct Times {
    std::optional<double> previous, now, next;
  };
  // A camera that follows a node of the scene.
  struct Follower {
    scene::Camera& camera;
    uint32_t node;
    scene::dmat4 toWorld;         // before variations
    scene::dmat4 baseFromCamera;  // the base is the scene's camera; a rig has offsets from it
  };
  void makeCamerasAt(std::optional<double> time, std::vector<JobCamera>& cameras, MemoryClaim& memory);
  void addFollowers(const scene::Pose& pose, std::vector<JobCamera>& cameras, MemoryClaim& memory);
  Times timesOf(size_t i) const;
  std::optional<size_t> indexOf(std::string_view camera) const;
  std::optional<Neighbor> inSequence(size_t i, std::optional<size_t> neighbor) const;

  const Job& job_;
  const scene::Scene& scene_;
  scene::Playback playback_;
  std::array<MemoryClaim, 3> memory_;  // for cameras_, earlier_ and later_, with their followers_
  std::vector<JobCamera> cameras_;
  std::map<std::string_view, size_t> byName_;  // indices of cameras_; empty unless the job pairs cameras by their names
  std::vector<JobCamera> earlier_, later_;     // by 1 / fps seconds; empty if the scene moves no camera
  std::vector<Follower> followers_;            // in cameras_, earlier_ and later_
};

}  // namespace latelight::data
