// The frames that a picture averages when its camera is more than a pinhole that is open for an instant: each frame is
// one sample of the pixel's area, of the exposure time and of the aperture (Haeberli and Akeley 1990, The Accumulation
// Buffer: Hardware Support for High-Quality Rendering; Cook, Porter and Carpenter 1984, Distributed Ray Tracing). The
// mean of the frames converges to the integral over all three.
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "render/settings/settings.h"

namespace latelight::render {

struct CameraSample {
  glm::vec2 jitter{0};  // offset from the pixel's center, in pixels, y down
  double seconds = 0;   // offset from the picture's time
  glm::dvec2 lens{0};   // point of the aperture, whose radius is 1: right and up
  bool operator==(const CameraSample&) const = default;
};

// Returns the N x N ordered grid of --aa ssN, row by row; the center of the pixel without it.
std::vector<CameraSample> pixelSamples(const Settings& settings);

// Returns samples of the pixel, of the exposure time and of the aperture: at least Settings::cameraSamples, and a
// multiple of the pixel's samples, so that each of these occurs equally often. Times are stratified: one sample is in
// the middle of each of as many intervals. Points of the aperture are those of an additive recurrence with the powers
// of the plastic number (Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences), mapped to a disk
// (Shirley and Chiu 1997, A Low Distortion Map Between Disk and Square) or to the polygon of the aperture's blades,
// each with uniform density.
std::vector<CameraSample> exposureSamples(const Settings& settings);

// Maps a point of the unit square to the aperture.
glm::dvec2 aperturePoint(const Settings& settings, glm::dvec2 square);

}  // namespace latelight::render
