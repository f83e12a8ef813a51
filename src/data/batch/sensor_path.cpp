#include "data/batch/sensor_path.h"

#include "base/hash.h"
#include "render/exposure/camera_motion.h"
#include "render/frame/view.h"
#include "render/submit/session.h"

namespace latelight::data {

CameraPath::CameraPath(const CameraTimeline& cameras, size_t camera, double seconds)
    : camera_(cameras.camera(camera).camera) {
  double begin = 0;
  for (std::optional<size_t> i = camera; i && begin < seconds;) {
    const std::optional<CameraTimeline::Neighbor> next = cameras.next(*i);
    const std::optional<double> step = next ? cameras.secondsTo(*i, *next) : std::nullopt;
    if (!step) break;
    legs_.push_back({begin, *step, cameras.camera(*i).camera, next->camera});
    begin += *step;
    i = next->place;
  }
  if (!legs_.empty()) return;
  const std::optional<CameraTimeline::Neighbor> previous = cameras.previous(camera);
  const std::optional<double> step = previous ? cameras.secondsTo(camera, *previous) : std::nullopt;
  if (step) legs_.push_back({-*step, *step, previous->camera, camera_});
}

scene::Camera CameraPath::at(double seconds) const {
  if (legs_.empty()) return camera_;
  size_t i = 0;
  while (i + 1 < legs_.size() && legs_[i + 1].begin <= seconds) ++i;
  const Leg& leg = legs_[i];
  const double share = (seconds - leg.begin) / leg.seconds;
  scene::Camera camera = leg.from;
  camera.toWorld = render::poseBetween(render::rigidPose(leg.from), render::rigidPose(leg.to), share);
  return camera;
}

namespace {

// Returns the seconds since the first scan of the camera's sequence, for sensors whose scans do not repeat.
double secondsOfScan(const CameraTimeline& cameras, size_t camera, double period) {
  const std::optional<SequencePosition>& place = cameras.camera(camera).sequence;
  if (place && place->seconds) return *place->seconds;
  if (const std::optional<double> time = cameras.time(camera)) return *time;
  return period * double(place ? place->number : camera);
}

}  // namespace

FrameScan scanFrom(render::Renderer& renderer, const scene::Scene& scene, const CameraTimeline& cameras, size_t camera,
                   const render::Settings& settings, const std::shared_ptr<const ScanRequest>& request, uint64_t seed) {
  const double period = 1 / request->sensor.rate;
  const lidar::Pattern pattern = lidar::patternOf(request->sensor, secondsOfScan(cameras, camera, period));
  const CameraPath path(cameras, camera, request->seconds);
  const auto poseAt = [&](double seconds) {
    return render::openCvPose(path.at(seconds), scene, settings.axes == render::Axes::ZUp) * request->cameraFromSensor;
  };
  FrameScan scan{request, cameras.time(camera), poseAt(0), {}};
  std::vector<glm::dmat4> poses{scan.worldFromSensor};
  if (!path.legs().empty()) {
    poses.clear();
    for (const double time : pattern.times) poses.push_back(poseAt(time));
  }
  const auto stateAt = [&](double seconds) {
    const scene::Pose pose = cameras.poseAt(scan.start ? std::optional(*scan.start + seconds) : std::nullopt);
    return render::SceneState{.poses = {pose, pose, pose}};
  };
  lidar::ScanOptions options = request->options;
  const uint64_t ofSensor[] = {seed, request->noiseStream};
  options.seed = hash64(ofSensor, sizeof(ofSensor));
  if (scene.rig.empty() || !scan.start) options.slices = 1;
  render::Settings ofRays = settings;
  ofRays.normalFrame = render::NormalFrame::World;  // scans have no normals, and rays accept no other frame
  scan.points = lidar::scan(renderer, pattern, poses, stateAt, ofRays, options);
  return scan;
}

}  // namespace latelight::data
