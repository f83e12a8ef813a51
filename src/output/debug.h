// AOVs as pictures, and the contact sheet that shows them side by side.
#pragma once

#include <span>
#include <string>

#include "output/aov.h"

namespace latelight::output {

// The picture by AOV: depth and distance in a perceptually even colour map over the range present, near is bright;
// normals as n * 0.5 + 0.5; positions as a grid in world space (decimetres to hectometres, depending on the extent);
// ids in distinct colours that are the same in every picture; uv as coloured squares, ten per unit; counts of lights on
// a logarithmic scale from 0 (black) to 4095 (white); albedo and emissive as sRGB; colour clamped; scalars as grey.
// Opaque. Background is a neutral dark grey; where values of 0 do not distinguish it from a black surface, `ids` of the
// same frame does, if given.
Picture debugPicture(const AovImage& image, const AovImage* ids = nullptr);

struct Labelled {
  std::string label;  // ASCII
  Picture picture;
};

// Pictures in reading order, each scaled down (averaged in linear light) to at most cellWidth pixels wide, its label
// below it, in as many lines as needed. Throws Error(Usage) if there is no picture.
Picture contactSheet(std::span<const Labelled> pictures, uint32_t columns = 4, uint32_t cellWidth = 480);

}  // namespace latelight::output
