// Bayer mosaics (Bayer 1976, Color Imaging Array, US patent 3971065): each pixel measures one color.
#pragma once

#include <vector>

#include "render/sensor/exposure_plane.h"

namespace latelight::render {

// Returns the color that a pixel measures: 0 red, 1 green, 2 blue. Bayer::None counts as rggb.
uint32_t filterAt(Bayer bayer, uint32_t x, uint32_t y);

// Returns the digital number of each pixel's own color.
std::vector<float> mosaicOf(const SensorPlane& plane, const Settings& settings);

// Returns the linear RGBA picture after white balance. A mosaic is interpolated by the linear filters of Malvar, He and
// Cutler (2004, High-Quality Linear Interpolation for Demosaicing of Bayer-Patterned Color Images); it is mirrored at
// its edges. Alpha is that of `rgba`.
std::vector<float> linearPicture(const SensorPlane& plane, const std::vector<float>& rgba, const Settings& settings);

}  // namespace latelight::render
