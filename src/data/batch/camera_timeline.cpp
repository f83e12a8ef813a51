#include "data/batch/camera_timeline.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/hash.h"
#include "render/frame/view.h"
#include "render/submit/session.h"

namespace latelight::data {

namespace {

void checkMembers(const std::vector<JobCamera>& cameras, const std::vector<PairTarget>& targets) {
  for (const PairTarget& target : targets) {
    if (target.kind != PairTarget::Kind::Member) continue;
    const std::string end = memberName("", target.name);
    if (std::ranges::none_of(cameras, [&](const JobCamera& camera) { return camera.name.ends_with(end); }))
      badUsage("correspondence leads to the member \"{}\", but no rig of the cameras has such a member", target.name);
  }
}

}  // namespace

CameraTimeline::CameraTimeline(const Job& job, const scene::Scene& scene) : job_(job), scene_(scene) {
  const render::Settings& s = job.settings;
  if (s.time) playback_ = scene::choosePlayback(scene, s.animation, s.loop);
  makeCamerasAt(s.time, cameras_, memory_[0]);
  const auto named = [](const PairTarget& target) { return target.kind != PairTarget::Kind::Step; };
  if (std::ranges::any_of(job.extras.pairs, named))
    for (size_t i = 0; i < cameras_.size(); ++i) byName_.emplace(cameras_[i].name, i);
  checkMembers(cameras_, job.extras.pairs);
  const auto followsScene = [](const JobCamera& camera) { return camera.sceneCamera.has_value(); };
  if (!s.time || !scene.rig.isAnimated() || std::ranges::none_of(cameras_, followsScene)) return;
  makeCamerasAt(*s.time - 1 / s.framesPerSecond, earlier_, memory_[1]);
  makeCamerasAt(*s.time + 1 / s.framesPerSecond, later_, memory_[2]);
}

void CameraTimeline::makeCamerasAt(std::optional<double> time, std::vector<JobCamera>& cameras, MemoryClaim& memory) {
  const render::Settings& s = job_.settings;
  CameraInputs inputs{.pose = poseAt(time)};
  if (job_.given.contains("size")) inputs.size = {s.width, s.height};
  cameras = makeCameras(job_.cameras, scene_, job_.seed, inputs, &memory);
  for (JobCamera& camera : cameras) {
    if (camera.width == 0) camera.width = s.width;
    if (camera.height == 0) camera.height = s.height;
    camera.camera = render::fitted(std::move(camera.camera), s.cameraFit);
  }
  addFollowers(inputs.pose, cameras, memory);
}

// Without variations no node moves, and no follower is required.
void CameraTimeline::addFollowers(const scene::Pose& pose, std::vector<JobCamera>& cameras, MemoryClaim& memory) {
  if (job_.variations.is_null()) return;
  const std::vector<scene::Camera> bases = scene::posedCameras(scene_, pose);
  for (JobCamera& camera : cameras) {
    if (!camera.sceneCamera || bases[*camera.sceneCamera].node < 0) continue;
    const scene::Camera& base = bases[*camera.sceneCamera];
    const scene::dmat4 baseFromCamera = glm::inverse(base.toWorld) * camera.camera.toWorld;
    memory.grow(2 * sizeof(Follower), "the job's cameras");  // the vector's capacity may be twice its length
    followers_.push_back({camera.camera, static_cast<uint32_t>(base.node), camera.camera.toWorld, baseFromCamera});
  }
}

void CameraTimeline::follow(const std::map<uint32_t, scene::dmat4>& movedNodes) {
  for (const Follower& follower : followers_) {
    follower.camera.toWorld = follower.toWorld;
    const auto moved = movedNodes.find(follower.node);
    if (moved == movedNodes.end()) continue;
    scene::placeCamera(follower.camera, scene::toGltfFromWorld() * moved->second);
    follower.camera.toWorld = follower.camera.toWorld * follower.baseFromCamera;
  }
}

std::optional<double> CameraTimeline::time(size_t i) const {
  const std::optional<double>& first = job_.settings.time;
  const std::optional<SequencePosition>& place = cameras_[i].sequence;
  if (!first || !place) return first;
  if (place->seconds) return *first + *place->seconds;
  const bool advances = job_.given.contains("fps");
  return advances ? *first + static_cast<double>(place->number) / job_.settings.framesPerSecond : *first;
}

// Returns no neighbor of another picture size, because motion vectors are in pixels of one size, and none of which only
// one has a lens that bends rays.
std::optional<CameraTimeline::Neighbor> CameraTimeline::inSequence(size_t i, std::optional<size_t> neighbor) const {
  if (!neighbor) return std::nullopt;
  const JobCamera &here = cameras_[i], &there = cameras_[*neighbor];
  if (here.width != there.width || here.height != there.height ||
      render::bendsRays(here.camera) != render::bendsRays(there.camera))
    return std::nullopt;
  return Neighbor{there.camera, time(*neighbor), neighbor};
}

std::optional<CameraTimeline::Neighbor> CameraTimeline::previous(size_t i) const {
  if (cameras_[i].sequence) return inSequence(i, cameras_[i].sequence->previous);
  const std::optional<double> now = time(i);
  if (!now) return std::nullopt;
  return Neighbor{(earlier_.empty() ? cameras_ : earlier_)[i].camera, *now - 1 / job_.settings.framesPerSecond, {}};
}

std::optional<CameraTimeline::Neighbor> CameraTimeline::next(size_t i) const {
  if (cameras_[i].sequence) return inSequence(i, cameras_[i].sequence->next);
  const std::optional<double> now = time(i);
  if (!now) return std::nullopt;
  return Neighbor{(later_.empty() ? cameras_ : later_)[i].camera, *now + 1 / job_.settings.framesPerSecond, {}};
}

std::optional<size_t> CameraTimeline::indexOf(std::string_view camera) const {
  const auto found = byName_.find(camera);
  return found == byName_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<CameraTimeline::Neighbor> CameraTimeline::target(size_t i, const PairTarget& target) const {
  const auto at = [&](std::optional<size_t> other) {
    return other && *other != i ? std::optional(Neighbor{cameras_[*other].camera, time(*other), other}) : std::nullopt;
  };
  if (target.kind == PairTarget::Kind::Camera) {
    const std::optional<size_t> other = indexOf(target.name);
    if (!other) badUsage("correspondence leads to the camera \"{}\", but the scene has no such camera", target.name);
    return at(other);
  }
  if (target.kind == PairTarget::Kind::Member) {
    const std::string& name = cameras_[i].name;
    const size_t dash = name.rfind('-');
    return dash == std::string::npos ? std::nullopt : at(indexOf(memberName(name.substr(0, dash), target.name)));
  }
  if (!cameras_[i].sequence) return target.step == 1 ? next(i) : target.step == -1 ? previous(i) : std::nullopt;
  std::optional<size_t> place = i;
  for (int64_t step = 0; place && step < std::abs(target.step); ++step)
    place = target.step > 0 ? cameras_[*place].sequence->next : cameras_[*place].sequence->previous;
  return at(place);
}

scene::Pose CameraTimeline::poseAt(const std::optional<double>& time) const {
  return time ? scene::poseAt(scene_, playback_, *time) : scene::Pose{};
}

std::optional<double> CameraTimeline::secondsTo(size_t i, const Neighbor& neighbor) const {
  std::optional<double> here = time(i), there = neighbor.time;
  if (neighbor.place && cameras_[i].sequence && cameras_[i].sequence->seconds) {
    here = cameras_[i].sequence->seconds;
    there = cameras_[*neighbor.place].sequence->seconds;
  }
  if (!here || !there || *here == *there) return std::nullopt;
  return std::abs(*there - *here);
}

std::function<scene::Pose(double)> CameraTimeline::posesNear(size_t i) const {
  if (!scene_.rig.isAnimated() || !time(i)) return nullptr;
  return [this, now = *time(i)](double seconds) { return scene::poseAt(scene_, playback_, now + seconds); };
}

CameraTimeline::Times CameraTimeline::timesOf(size_t i) const {
  const std::optional<double> now = time(i);
  const std::optional<Neighbor> before = previous(i), after = next(i);
  return {before ? before->time : now, now, after ? after->time : now};
}

render::Poses CameraTimeline::poses(size_t i) const {
  const Times times = timesOf(i);
  return {poseAt(times.previous), poseAt(times.now), poseAt(times.next)};
}

render::Settings CameraTimeline::settingsOf(size_t i) const {
  const CameraExposure& exposure = cameras_[i].exposure;
  render::Settings settings = job_.settings;
  if (exposure.shutter) settings.shutter = *exposure.shutter;
  if (exposure.readout) settings.readout = *exposure.readout;
  if (exposure.ev) settings.exposure = static_cast<float>(*exposure.ev);
  return settings;
}

uint64_t CameraTimeline::momentOf(size_t i) const {
  const CameraExposure& exposure = cameras_[i].exposure;
  std::vector<uint64_t> parts;
  const auto add = [&](const std::optional<double>& seconds) { parts.push_back(std::bit_cast<uint64_t>(*seconds)); };
  if (scene_.rig.isAnimated() && job_.settings.time) {
    const Times times = timesOf(i);
    for (const auto& time : {times.previous, times.now, times.next}) add(time);
  }
  if (exposure.shutter || exposure.readout) {
    add(exposure.shutter.value_or(job_.settings.shutter));
    add(exposure.readout.value_or(job_.settings.readout));
  }
  if (exposure.ev) add(exposure.ev);
  return parts.empty() ? 0 : hash64(parts.data(), parts.size() * sizeof(uint64_t));
}

}  // namespace latelight::data
