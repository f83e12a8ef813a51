// The camera source "sphere": positions on a sphere or in a shell around a target, on a Fibonacci grid or random.
// Random positions are drawn by rejection sampling.
#include <cmath>

#include "base/error.h"
#include "data/cameras/around.h"
#include "data/cameras/clearance.h"
#include "data/cameras/optics.h"
#include "data/cameras/target.h"
#include "scene/exact_math.h"

namespace latelight::data {

namespace {

struct Shell {
  Target target;
  Interval radius, height;  // height is the sine of the elevation; the area is uniform in it
};

// Returns point `i` of `count` of a Fibonacci grid: heights are in equal steps, and each azimuth is a golden angle from
// the previous one.
glm::dmat4 gridPose(const Shell& shell, const CameraContext& context, uint64_t i, uint64_t count, Random& random) {
  constexpr double kGolden = 0.61803398874989485;
  const double height = shell.height.low + (shell.height.high - shell.height.low) * ((double(i) + 0.5) / double(count));
  const double turns = double(i) * kGolden;
  return around(context.axes, turns - std::floor(turns), height)
      .pose(shell.target.center, random.between(shell.radius.low, shell.radius.high));
}

glm::dmat4 randomPose(const Shell& shell, const CameraContext& context, Random& random) {
  const double height = random.between(shell.height.low, shell.height.high);
  const double turns = random.unit();
  return around(context.axes, turns, height)
      .pose(shell.target.center, random.between(shell.radius.low, shell.radius.high));
}

}  // namespace

std::vector<Shot> shotsOnSphere(Spec& spec, const CameraContext& context) {
  const Optics optics = readOptics(spec, context.size);
  const uint64_t count = spec.count("count", 1, kMaxCameras);
  context.claim(spec, count, count * kNumberedNameBytes);
  const bool grid = spec.choice("points", {"fibonacci", "random"}, "fibonacci") == "fibonacci";
  const Interval elevation = spec.interval("elevation", {-90, 90}, Interval{-90, 90});
  const Target target = readTarget(spec, context);
  const Shell shell{target,
                    readDistance(spec, "radius", target, optics.halfAngle),
                    {exact::sinQuarters(elevation.low / 90), exact::sinQuarters(elevation.high / 90)}};
  const Clearance clearance(spec, context);
  std::vector<Shot> shots;
  for (uint64_t i = 0; i < count; ++i) {
    Random random(context.seed, i, spec.path());
    glm::dmat4 pose = grid ? gridPose(shell, context, i, count, random) : randomPose(shell, context, random);
    bool allowed = clearance.allows(glm::dvec3(pose[3]));
    for (uint32_t tried = 1; !grid && !allowed; ++tried) {
      if (tried == kTries) failWithoutPosition(spec, i, count);
      pose = randomPose(shell, context, random);
      allowed = clearance.allows(glm::dvec3(pose[3]));
    }
    // Rejected points of the grid are skipped, because replacements would make it uneven.
    if (allowed) shots.push_back({numberedName("sphere", i, count), pose, optics.camera, optics.width, optics.height});
  }
  if (shots.empty()) badUsage("{}: no point of the sphere is free: all lie inside geometry or too near", spec.path());
  return shots;
}

}  // namespace latelight::data
