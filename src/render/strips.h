// Large pictures in horizontal strips: each is rendered as a picture of its own, so that what the device works on takes
// no more memory than a strip of it.
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
// ambient occlusion, FXAA and temporal anti-aliasing. By size and settings alone, so that the same picture is always
// made of the same strips. Seams lie between blocks of pixels that are shaded together, so that none shows.
std::vector<Strip> stripsOf(const Settings& settings);

// What a view of the whole picture shows in the strip: each pixel has the same ray.
shared::View viewOf(const shared::View& whole, Strip strip);

// Puts a strip's outputs under those of the strips above it; `whole` has its size and its outputs, and is empty at
// first. Memory for all of its rows is set aside then.
void append(output::FrameOutput& whole, const output::FrameOutput& strip);

}  // namespace latelight::render
