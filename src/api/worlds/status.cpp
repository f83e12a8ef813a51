// The status that shaders report for each world, as errors and warnings.
#include "api/scene.h"
#include "api/worlds/messages.h"
#include "base/error.h"
#include "base/log.h"
#include "render/gpu_scene/world_inputs_push.h"

namespace latelight {

std::vector<uint32_t> worldsOfStatus(std::span<const uint32_t> status) {
  std::vector<uint32_t> invalid;
  for (uint32_t world = 0; world < status.size(); ++world) {
    const uint32_t bits = status[world];
    if (bits & shared::kWorldWrongTransform)
      badUsage("the transform of an instance must have the last row 0 0 0 1, and one of world {} has another", world);
    if (bits & shared::kWorldWrongJoint) badUsage(kWrongJoint, world);
    if (bits & shared::kWorldWrongPose)
      badUsage(
          "the camera's pose must be a rotation and a translation, without mirror, shear or scale, over 0 0 0 1, and "
          "one in world {} is not",
          world);
    if (bits & shared::kWorldWrongIntrinsics) badUsage(kWrongIntrinsics, world);
    if (bits & shared::kWorldWrongRide) badUsage(kWrongRide, world);
    if (bits & shared::kWorldWrongFactors) badUsage(kWrongFactors, world);
    if (bits & shared::kWorldWrongEnvironmentIndex) badUsage(kWrongEnvironmentIndex, world);
    if (bits & shared::kWorldWrongChoice) badUsage(kWrongChoice, world);
    if (bits & shared::kWorldWrongLight)
      badUsage("colors and intensities of lights must be at least 0, and one of world {} is not", world);
    if (bits & shared::kWorldWrongDirection)
      badUsage("the direction of a light must have a length above 0, and one in world {} does not", world);
    if (bits & shared::kWorldWrongEnvironment) badUsage(kWrongEnvironment, world);
    if (bits & shared::kWorldNotFinite) invalid.push_back(world);
  }
  return invalid;
}

void warnOfInvalidWorlds(const std::vector<uint32_t>& invalid, size_t worlds) {
  if (!invalid.empty())
    warn("{} of {} worlds have values that are not finite, and show only the background; the first is world {}",
         invalid.size(), worlds, invalid.front());
}

}  // namespace latelight
