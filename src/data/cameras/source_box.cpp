// The camera source "box": random positions in a box, by rejection sampling. Cameras look at a target or in random
// directions.
#include "base/error.h"
#include "data/cameras/around.h"
#include "data/cameras/clearance.h"
#include "data/cameras/optics.h"
#include "data/cameras/target.h"

namespace latelight::data {

namespace {

Aabb readBox(Spec& spec, const CameraContext& context) {
  if (!spec.has("min") && !spec.has("max")) return boxOfScene(context.scene, spec.path());
  const Aabb box{spec.vector("min"), spec.vector("max")};
  if (!(box.low.x <= box.high.x && box.low.y <= box.high.y && box.low.z <= box.high.z))
    badUsage("{} must be at most {} along each axis", spec.pathOf("min"), spec.pathOf("max"));
  return box;
}

}  // namespace

std::vector<Shot> shotsInBox(Spec& spec, const CameraContext& context) {
  const Optics optics = readOptics(spec, context.size);
  const uint64_t count = spec.count("count", 1, kMaxCameras);
  context.claim(spec, count, count * kNumberedNameBytes);
  const Aabb box = readBox(spec, context);
  const bool anywhere = spec.has("target") && spec.at("target") == "random";
  const Target target = anywhere ? Target{} : readTarget(spec, context);
  const Clearance clearance(spec, context);
  std::vector<Shot> shots;
  for (uint64_t i = 0; i < count; ++i) {
    Random random(context.seed, i, spec.path());
    for (uint32_t tried = 0;; ++tried) {
      if (tried == kTries) failWithoutPosition(spec, i, count);
      glm::dvec3 eye;
      for (int axis = 0; axis < 3; ++axis) eye[axis] = random.between(box.low[axis], box.high[axis]);
      const double turns = random.unit(), height = random.between(-1, 1);
      if (!clearance.allows(eye) || (!anywhere && eye == target.center)) continue;
      // For a random view direction, around() at distance 0 places the camera at the eye itself.
      const glm::dmat4 pose = anywhere ? around(context.axes, turns, height).pose(eye, 0)
                                       : lookAtPose(context.axes, eye, target.center, nullptr, spec.path());
      shots.push_back({numberedName("box", i, count), pose, optics.camera, optics.width, optics.height});
      break;
    }
  }
  return shots;
}

}  // namespace latelight::data
