// Messages of wrong worlds, which the host and the device find alike.
#pragma once

namespace latelight {

inline constexpr char kWrongJoint[] =
    "the transform of a joint must have the last row 0 0 0 1, and one of world {} has another";
inline constexpr char kWrongRide[] =
    "a camera of world {} rides on an instance whose transform mirrors, shears or has an axis of length 0";
inline constexpr char kWrongIntrinsics[] =
    "a camera matrix k must have focal lengths above 0, no skew and the last row 0 0 1, and one in world {} does not";
inline constexpr char kWrongFactors[] =
    "factors of materials must be at least 0, and metallic and roughness at most 1, and one of world {} is not";
inline constexpr char kWrongEnvironmentIndex[] =
    "the environments of worlds must be indices in the list of environments, and that of world {} is not";
inline constexpr char kWrongChoice[] =
    "material choices must be indices in the list of materials, and one of world {} is not";
inline constexpr char kWrongEnvironment[] =
    "the intensity of the environment must be at least 0, and that of world {} is not";

}  // namespace latelight
