#include "data/cameras/pose_spec.h"

#include "base/error.h"
#include "data/cameras/target.h"

namespace latelight::data {

glm::dmat4 readPoseMatrix(Spec& spec) {
  const bool openGl = spec.choice("frame", {"opencv", "opengl"}, "opencv") == "opengl";
  const glm::dmat4 pose = poseOf(spec.matrix("pose", 4, 4), spec.pathOf("pose"));
  return openGl ? turnedAxes(pose) : pose;
}

glm::dmat4 readPose(Spec& spec, const CameraContext& context) {
  if (spec.has("pose") == spec.has("eye")) badUsage("{} needs either \"eye\" or \"pose\"", spec.path());
  if (spec.has("pose")) return readPoseMatrix(spec);
  if (spec.has("frame")) badUsage("{} is the camera frame of \"pose\": omit it with \"eye\"", spec.pathOf("frame"));
  const glm::dvec3 eye = spec.vector("eye"), target = readTarget(spec, context).center;
  if (!spec.has("up")) return lookAtPose(context.axes, eye, target, nullptr, spec.path());
  const glm::dvec3 up = spec.vector("up");
  return lookAtPose(context.axes, eye, target, &up, spec.path());
}

}  // namespace latelight::data
