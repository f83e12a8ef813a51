// Large pictures in horizontal strips: each is rendered as a picture of its own, so that the device needs memory for
// one strip only.
#pragma once

#include <cstdint>
#include <vector>

#include "output/files.h"
#include "render/settings.h"
#include "shared/types.h"

namespace latelight::render {

// Rows of a picture.
struct Strip {
  uint32_t first, rows;
};

// From the top; the whole picture where it is small, or where a pixel of it depends on pixels far away: with bloom,
// ambient occlusion, FXAA and temporal anti-aliasing, and where surfaces are `transmissive`. Depends on nothing else,
// so that the same picture always has the same strips. Seams lie between blocks of pixels that are shaded together, so
// that none is visible.
std::vector<Strip> stripsOf(const Settings& settings, bool transmissive = false);

// The strip's part of a view of the whole picture: each pixel has the same ray.
shared::View viewOf(const shared::View& whole, Strip strip);

// Appends a strip's outputs below those of earlier strips. `whole` is empty at first; memory for all of its rows is
// reserved then.
void append(output::FrameOutput& whole, const output::FrameOutput& strip);

}  // namespace latelight::render
