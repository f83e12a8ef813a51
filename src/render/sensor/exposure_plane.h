// Photons to electrons to digital numbers.
#pragma once

#include <cstdint>
#include <vector>

#include "render/settings/settings.h"

namespace latelight::render {

// The signal of a sensor: 1 is the highest digital number, 0 the black level. Noise makes it negative.
struct SensorPlane {
  uint32_t width = 0, height = 0;
  std::vector<float> rgb;  // three channels per pixel; of a mosaic, only that of the pixel's filter is set
};

// Exposes the sensor to an RGBA picture. `seed` distinguishes frames.
SensorPlane exposeSensor(const std::vector<float>& rgba, const Settings& settings, uint64_t seed);

}  // namespace latelight::render
