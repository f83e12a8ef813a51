// Debug images of AOVs, and the contact sheet that shows them side by side.
#pragma once

#include <span>
#include <string>

#include "output/aov.h"

namespace latelight::output {

// Paints an AOV. Depth and distance use a perceptually even color map over the range present, where near is bright.
// Normals are n * 0.5 + 0.5. Positions are a grid in world space (decimeters to hectometers, depending on the extent).
// Ids have distinct colors that are the same in every image. UV are colored squares, ten per unit. Counts of lights are
// on a logarithmic scale from 0 (black) to 4095 (white). Albedo and emissive are sRGB, color is clamped, and scalars
// are gray. The image is opaque. Background is a neutral dark gray. If values of 0 do not distinguish it from a black
// surface, `ids` of the same frame does, if passed.
Picture debugPicture(const AovImage& image, const AovImage* ids = nullptr);

struct Labelled {
  std::string label;  // ASCII
  Picture picture;
};

// Arranges images in reading order. Each is scaled down (averaged in linear light) to at most cellWidth pixels, with
// its label below in as many lines as needed. Throws Error(Usage) if there is no image.
Picture contactSheet(std::span<const Labelled> pictures, uint32_t columns = 4, uint32_t cellWidth = 480);

}  // namespace latelight::output
