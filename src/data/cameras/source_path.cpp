// The camera source "path": a smooth path through key frames. Positions follow centripetal Catmull-Rom curves,
// rotations squad or slerp (path.h), and the field of view is interpolated linearly.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "data/cameras/calibrated.h"
#include "data/cameras/optics.h"
#include "data/cameras/path.h"
#include "data/cameras/pose_spec.h"

namespace latelight::data {

namespace {

struct KeyFrame {
  double time = 0;
  glm::dmat4 pose{1};
  float fov = 0;
  glm::dvec4 rotation{1, 0, 0, 0};  // its sign is chosen for the shorter rotation from the previous key frame
};

struct Keys {
  std::vector<KeyFrame> frames;
  bool timed = false;  // the job specifies the times
};

Keys readKeys(Spec& spec, const CameraContext& context, const Optics& optics) {
  std::vector<Spec> entries = spec.objects("keys");
  if (entries.size() < 2) badUsage("{} must have at least two key frames", spec.pathOf("keys"));
  const bool timed = entries[0].has("time");
  std::vector<KeyFrame> keys;
  for (Spec& entry : entries) {
    if (entry.has("time") != timed) badUsage("{} must have a time in all keyframes or in none", spec.pathOf("keys"));
    KeyFrame key{timed ? entry.number("time") : double(keys.size()), readPose(entry, context)};
    if (!keys.empty() && !(key.time > keys.back().time))
      badUsage("{} must be later than the key frame before", entry.pathOf("time"));
    key.fov = optics.camera.verticalFov;
    if (entry.has("fov") && optics.camera.lens) badUsage("{} cannot be combined with a lens", entry.pathOf("fov"));
    if (entry.has("fov")) key.fov = readFov(entry);
    entry.finish();
    key.rotation = quaternionOf(glm::dmat3(key.pose));
    if (!keys.empty() && glm::dot(key.rotation, keys.back().rotation) < 0) key.rotation = -key.rotation;
    keys.push_back(key);
  }
  return {std::move(keys), timed};
}

// Returns the pose between key frame i (share 0) and the next one (share 1).
glm::dmat4 poseBetween(const std::vector<KeyFrame>& keys, size_t i, double share, bool smoothTurns) {
  const auto place = [&](size_t key) { return glm::dvec3(keys[key].pose[3]); };
  const bool first = i == 0, last = i + 2 == keys.size();
  // Beyond its ends a path continues straight.
  const glm::dvec3 before = first ? 2.0 * place(0) - place(1) : place(i - 1);
  const glm::dvec3 after = last ? 2.0 * place(i + 1) - place(i) : place(i + 2);
  const glm::dvec4 a = keys[i].rotation, b = keys[i + 1].rotation;
  const glm::dvec4 controlA = first ? a : squadControl(keys[i - 1].rotation, a, b);
  const glm::dvec4 controlB = last ? b : squadControl(a, b, keys[i + 2].rotation);
  glm::dmat4 pose(rotationOf(smoothTurns ? squad(a, controlA, controlB, b, share) : slerp(a, b, share)));
  pose[3] = glm::dvec4(catmullRom({before, place(i), place(i + 1), after}, share), 1);
  return pose;
}

std::vector<double> readTimes(Spec& spec, double first, double last, const CameraContext& context) {
  if (spec.has("count") == spec.has("fps")) badUsage("{} needs either \"count\" or \"fps\"", spec.path());
  std::vector<double> times;
  if (spec.has("count")) {
    const uint64_t count = spec.count("count", 2, kMaxCameras);
    context.claim(spec, count, count * kNumberedNameBytes);
    for (uint64_t i = 0; i < count; ++i) times.push_back(first + (last - first) * (double(i) / double(count - 1)));
    return times;
  }
  const double fps = spec.number("fps", kPositive);
  if ((last - first) * fps > double(kMaxCameras))
    badUsage("{} gives more than {} cameras", spec.pathOf("fps"), kMaxCameras);
  // Rounding must not drop a frame at the last key frame: times that are not binary fractions, such as 0.3, are off by
  // up to half a unit in the last place.
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(std::abs(first), std::abs(last)) * fps;
  const auto count = static_cast<uint64_t>(std::floor((last - first) * fps + 1e-9 + rounding)) + 1;
  context.claim(spec, count, count * kNumberedNameBytes);
  for (uint64_t i = 0; i < count; ++i) times.push_back(std::min(first + double(i) / fps, last));
  return times;
}

}  // namespace

std::vector<Shot> shotsOnPath(Spec& spec, const CameraContext& context) {
  const Optics optics = readOptics(spec, context.size);
  const bool smoothTurns = spec.choice("rotation", {"squad", "slerp"}, "squad") == "squad";
  const auto [keys, timed] = readKeys(spec, context, optics);
  const std::vector<double> times = readTimes(spec, keys.front().time, keys.back().time, context);
  std::vector<Shot> shots;
  for (const double time : times) {
    const auto next = std::ranges::upper_bound(keys, time, {}, &KeyFrame::time);
    const size_t i = std::min<size_t>(static_cast<size_t>(next - keys.begin()), keys.size() - 1) - 1;
    const double share = std::min(1.0, (time - keys[i].time) / (keys[i + 1].time - keys[i].time));
    Shot shot{numberedName("path", shots.size(), times.size()), poseBetween(keys, i, share, smoothTurns), optics.camera,
              optics.width, optics.height};
    shot.optics.verticalFov = keys[i].fov + (keys[i + 1].fov - keys[i].fov) * static_cast<float>(share);
    shots.push_back(std::move(shot));
  }
  // Key frames without times are one second apart only by convention, so they do not set the scene's time.
  makeSequence(shots, timed || spec.has("fps") ? times : std::vector<double>());
  return shots;
}

}  // namespace latelight::data
