#include "data/cameras/shot.h"

#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "data/spec.h"
#include "render/submit/session.h"

namespace latelight::data {

using glm::dmat4, glm::dvec3, glm::dvec4;

SceneAxes axesOf(const scene::Scene& scene) {
  if (scene.yUp) return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
}

dmat4 lookAtPose(const SceneAxes& axes, dvec3 eye, dvec3 target, const dvec3* up, const std::string& path) {
  const double distance = glm::length(target - eye);
  if (!(distance > 0) || !std::isfinite(distance)) badUsage("{} has its eye and its target at the same place", path);
  const dvec3 away = (target - eye) / distance;
  dvec3 upward = up ? *up : axes.up;
  if (!up && glm::length(glm::cross(away, upward)) < 1e-6) upward = -axes.front;
  const dvec3 right = glm::cross(away, upward);
  const double across = glm::length(right);
  if (!(across > 1e-6 * glm::length(upward)))
    badUsage("{}.up is zero or parallel to the view: give another direction", path);
  const dvec3 unit = right / across;
  return dmat4(dvec4(unit, 0), dvec4(glm::cross(away, unit), 0), dvec4(away, 0), dvec4(eye, 1));
}

dmat4 turnedAxes(const dmat4& pose) {
  return dmat4(pose[0], -pose[1], -pose[2], pose[3]);
}

bool makeRigid(dmat4& pose) {
  constexpr double kTolerance = 1e-3;
  const dvec3 x(pose[0]), y(pose[1]), z(pose[2]);
  const double errors[] = {glm::dot(x, x) - 1, glm::dot(y, y) - 1, glm::dot(z, z) - 1,
                           glm::dot(x, y),     glm::dot(y, z),     glm::dot(z, x)};
  for (const double error : errors)
    if (!(std::abs(error) < kTolerance)) return false;
  if (glm::dot(glm::cross(x, y), z) < 0) return false;
  for (int i = 0; i < 4; ++i)
    if (!(std::abs(pose[3][i]) < kLargest) || pose[i][3] != (i == 3 ? 1 : 0)) return false;
  const dvec3 unitZ = z / glm::length(z), across = glm::cross(y, unitZ), unitX = across / glm::length(across);
  pose[0] = dvec4(unitX, 0), pose[1] = dvec4(glm::cross(unitZ, unitX), 0), pose[2] = dvec4(unitZ, 0);
  return true;
}

dmat4 poseOf(const std::vector<double>& rows, const std::string& path) {
  dmat4 pose(1);
  for (int i = 0; i < 16; ++i) pose[i % 4][i / 4] = rows[static_cast<size_t>(i)];
  if (!makeRigid(pose)) badUsage("{} must be a rotation and a translation, with the last row 0 0 0 1", path);
  return pose;
}

void makeSequence(std::vector<Shot>& shots, const std::vector<double>& seconds) {
  std::map<std::string_view, size_t> last;  // the latest and the first shot of each folder
  std::map<std::string_view, size_t> first;
  for (size_t i = 0; i < shots.size(); ++i) {
    const std::string_view name = shots[i].name;
    const std::string_view folder = name.substr(0, name.rfind('/') + 1);
    SequencePosition& place = shots[i].sequence.emplace();
    const size_t start = first.try_emplace(folder, i).first->second;
    if (!seconds.empty()) place.seconds = seconds[i] - seconds[start];
    const auto [before, isFirst] = last.try_emplace(folder, i);
    if (isFirst) continue;
    SequencePosition& other = *shots[before->second].sequence;
    place.number = other.number + 1;
    place.previous = std::exchange(before->second, i);
    other.next = i;
  }
}

JobCamera toJobCamera(const Shot& shot, const scene::Scene& scene) {
  JobCamera camera{shot.optics,   shot.name,     shot.width,       shot.height,
                   shot.sequence, shot.exposure, shot.sceneCamera, shot.member};
  camera.camera.name = shot.name;
  camera.camera.toWorld = render::toWorldFromOpenCv(shot.pose, scene);
  return camera;
}

Shot toShot(const scene::Camera& camera, const scene::Scene& scene) {
  return {camera.name, render::openCvPose(camera, scene, false), camera};
}

}  // namespace latelight::data
