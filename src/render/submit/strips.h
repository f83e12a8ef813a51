// Splits large pictures into horizontal strips. Each strip is rendered as a picture of its own, so that the device
// needs memory for only one strip.
#pragma once

#include <cstdint>
#include <vector>

#include "output/files.h"
#include "render/settings/settings.h"
#include "shared/types.h"

namespace latelight::render {

// A range of rows of a picture.
struct Strip {
  uint32_t first, rows;
  bool operator==(const Strip&) const = default;
};

// Returns the strips from top to bottom. A picture is a single strip if it is small, or if its pixels depend on distant
// pixels: with bloom, ambient occlusion, filtered indirect light, FXAA or temporal anti-aliasing, and with
// `transmissive` surfaces. The result depends on nothing else, so that the same picture always has the same strips.
// Seams lie between blocks of pixels that are shaded together, so that none is visible.
std::vector<Strip> stripsOf(const Settings& settings, bool transmissive = false);

// Returns the strip's part of a view of the full picture. Each pixel has the same ray.
shared::View viewOf(const shared::View& whole, Strip strip);

// Appends a strip's outputs below those of earlier strips. `whole` is empty at first; the first call reserves memory
// for all of its rows.
void append(output::FrameOutput& whole, const output::FrameOutput& strip);

}  // namespace latelight::render
