// Light volumes: values of the option, and constants that tests need.
#pragma once

#include <cstdint>

namespace latelight::render {

// Values of FrameConfig::volumesOrder, numbered as VolumesOrder.
inline constexpr uint32_t kVolumesClassic = 0, kVolumesKillzone = 1;

// In pixels. A volume whose projected sphere has a smaller radius is lit without a stencil mark, because marking would
// cost more than it saves. The picture is the same.
inline constexpr float kMinMarkedRadius = 8;

}  // namespace latelight::render
