// The filters of indirect light (--indirect-filter).
#pragma once

#include "render/frame/frame_history.h"

namespace latelight::render {

// The images that paths.comp writes for the filter, one layer per view.
struct IndirectSignals {
  // Radiance through the Lambertian and the specular lobe, divided by their albedos. w: variance of its luminance.
  graph::ImageId scattered, mirrored;
  graph::ImageId guide;  // position (bits of floats) and octahedral normal (2 x 16 bits, signed); 0: no surface
  graph::ImageId scatteredAlbedo;  // w: perceptual roughness
  graph::ImageId mirroredAlbedo;   // w: 1 where there is light to filter, else 0
};

// Returns the history of filtered light (FrameContext::indirectHistory), without frames.
FrameHistory indirectHistory();

// Averages the signals with those of earlier frames if the frame has a history, which then advances; filters them, and
// adds them, times their albedos, to the lit picture.
void addIndirectFilter(const FrameContext& f, const IndirectSignals& signals, const VisibilityBuffer& visible,
                       graph::ImageId light);

}  // namespace latelight::render
