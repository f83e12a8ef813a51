// volumes: what can be chosen, and what its tests want to know.
#pragma once

#include <cstdint>

namespace latelight::render {

// FrameSetup::volumesOrder, as VolumesOrder numbers it.
inline constexpr uint32_t kVolumesClassic = 0, kVolumesKillzone = 1;

// Pixels. A volume whose sphere looks smaller is lit without being marked first: the marking would cost more than it
// saves, and the picture is the same.
inline constexpr float kLeastMarkedRadius = 8;

}  // namespace latelight::render
