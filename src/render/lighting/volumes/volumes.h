// volumes: its options, and the constants that its tests need.
#pragma once

#include <cstdint>

namespace latelight::render {

// FrameSetup::volumesOrder, as VolumesOrder numbers it.
inline constexpr uint32_t kVolumesClassic = 0, kVolumesKillzone = 1;

// Pixels. A volume whose projected sphere is smaller is lit without being marked first: marking would cost more than it
// saves, and the picture is the same.
inline constexpr float kLeastMarkedRadius = 8;

}  // namespace latelight::render
