// The request of --debug: images of data, for viewing.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "output/files.h"
#include "output/targets.h"

namespace latelight::output {

struct DebugRequest {
  std::vector<Aov> aovs;
  bool sheet = false;    // several images, side by side
  bool targets = false;  // the layout's own render targets, instead of AOVs
  std::string target{};  // only this target; empty: all
};

// Parses "sheet" (all AOVs except raw, samples, raster-* and, unless `moving`, motion), "lights", comma-separated AOV
// names, "targets" or "target:NAME". Throws Error(Usage).
DebugRequest parseDebug(std::string_view text, bool moving);

// The value of {aov} in the file name of the debug image.
std::string_view debugName(const DebugRequest& request);

// Paints AOVs. The frame must have the requested AOVs; if it also has ids, they tell background from surfaces.
Picture debugPicture(const DebugRequest& request, const FrameOutput& frame);
// Paints render targets.
Picture debugPicture(const DebugRequest& request, const RawGbuffer& gbuffer);

}  // namespace latelight::output
