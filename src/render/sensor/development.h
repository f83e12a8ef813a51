// From the sensor's linear picture to the finished one.
#pragma once

#include <cstdint>
#include <vector>

#include "render/settings/settings.h"

namespace latelight::render {

// Returns the 8-bit RGBA picture of a premultiplied linear one: by the response curve or, as without a sensor
// (post/compose.glsl), by tone mapping and sRGB. Alpha is straight.
std::vector<uint8_t> developed(const std::vector<float>& rgba, const Settings& settings);

}  // namespace latelight::render
