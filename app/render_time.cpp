#include "app/render_time.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "app/parse.h"
#include "app/render_camera.h"
#include "app/render_correspond.h"
#include "base/error.h"

namespace latelight::app {

namespace {

constexpr uint32_t kMaxFrames = 1'000'000;

// Returns the point of --target, or the center of the scene at rest.
glm::dvec3 pivotOf(const scene::Scene& scene, const RenderOptions& o) {
  if (!o.target.empty()) {
    const glm::dvec3 target = parseVector("--target", o.target);
    return scene.yUp ? glm::dvec3(scene::toWorldFromGltf() * glm::dvec4(target, 1)) : target;
  }
  const scene::Bounds bounds = scene::worldBounds(scene);
  return bounds.empty() ? glm::dvec3(0) : bounds.center();
}

// Throws if the frames of a sequence would all be written to one file, or to standard output. `ending` is the example's
// extension for a pattern that has none.
void checkFramePattern(const char* option, const std::string& pattern, const char* ending) {
  if (pattern.empty() || pattern.find("{frame}") != std::string::npos) return;
  const std::string own = std::filesystem::path(pattern).extension().string();
  badUsage(
      "--frames requires {{frame}} in {0}, such as {0} out/{{frame}}{1}; otherwise each frame would replace the "
      "previous one",
      option, own.empty() ? ending : own);
}

}  // namespace

void checkTime(const RenderOptions& o) {
  const bool timed = o.settings.time.has_value();
  if (timed && !o.frames.empty()) badUsage("--time and --frames both set the time; use one of them");
  if (o.frames.empty()) {
    if (render::playsWithoutTime(o.settings)) badUsage("--animation and --loop require --time or --frames");
    return;
  }
  if (!o.picks.empty()) badUsage("--pick applies to one time: use --time instead of --frames");
  const auto [first, last] = parseFrames(o.frames);
  if (last - first >= kMaxFrames) badUsage("--frames takes at most {} frames, not \"{}\"", kMaxFrames, o.frames);
  if (o.isExplicit("frame")) badUsage("--frame and --frames both set {{frame}}; use one of them");
  if (first == last) return;
  checkFramePattern("-o", o.out, ".png");
  checkFramePattern("--labels", o.labels, ".json");
  checkFramePattern("--correspond", o.correspond, ".npz");
}

Timeline::Timeline(const scene::Scene& scene, const RenderOptions& o)
    : scene_(scene),
      options_(o),
      playback_(scene::choosePlayback(scene, o.settings.animation, o.settings.loop)),
      pivot_(pivotOf(scene, o)),
      sequence_(!o.frames.empty()),
      still_(!sequence_ && !o.settings.time) {
  if (sequence_)
    std::tie(first_, last_) = parseFrames(o.frames);
  else
    first_ = last_ = o.frame;
}

uint32_t Timeline::frameDigits() const {
  return std::max<uint32_t>(4, static_cast<uint32_t>(fmt::formatted_size("{}", last_)));
}

std::optional<double> Timeline::secondsAt(uint32_t frame) const {
  if (sequence_) return frame / options_.settings.framesPerSecond;
  return options_.settings.time;
}

scene::Pose Timeline::poseAt(double seconds) const {
  return still_ ? scene::Pose{} : scene::poseAt(scene_, playback_, seconds);
}

scene::Camera Timeline::cameraAt(double seconds, const RenderOptions& o) const {
  scene::Camera camera = chooseCamera(scene_, scene::posedCameras(scene_, poseAt(seconds)), o);
  if (o.turn == 0) return camera;
  const double angle = std::fmod(o.turn * seconds, 360.0) * M_PI / 180.0;
  glm::dmat4 about = glm::translate(glm::dmat4(1), pivot_);
  about = glm::rotate(about, angle, glm::dvec3(0, 0, 1));
  camera.toWorld = glm::translate(about, -pivot_) * camera.toWorld;
  return camera;
}

scene::Camera Timeline::cameraAt(uint32_t frame) const {
  scene::Camera camera = cameraAt(secondsAt(frame).value_or(0));
  camera.noiseSeed = frame;
  return camera;
}

Timeline::SecondPicture Timeline::secondPicture(uint32_t frame) const {
  const double here = secondsAt(frame).value_or(0);
  const double then =
      options_.toTime.value_or(here + static_cast<double>(stepToSecond(options_)) / options_.settings.framesPerSecond);
  return {cameraAt(then, optionsOfSecond(options_)), poseAt(then)};
}

render::SceneState Timeline::momentAt(uint32_t frame) const {
  const double seconds = secondsAt(frame).value_or(0), step = 1 / options_.settings.framesPerSecond;
  render::SceneState moment{.poses = {poseAt(seconds - step), poseAt(seconds), poseAt(seconds + step)}};
  moment.previousCameras = {cameraAt(seconds - step)};
  moment.nextCameras = {cameraAt(seconds + step)};
  moment.continues = frame > first_;
  const bool isAnimated = !still_ && !scene_.rig.empty();
  if (isAnimated) moment.motion.poseAt = [this, seconds](double offset) { return poseAt(seconds + offset); };
  if (isAnimated || options_.turn != 0)
    moment.motion.cameraAt = [this, seconds](size_t, double offset) { return cameraAt(seconds + offset); };
  return moment;
}

}  // namespace latelight::app
