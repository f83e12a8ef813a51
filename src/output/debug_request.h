// What --debug asks for: pictures of data, for the eye.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "output/files.h"
#include "output/targets.h"

namespace latelight::output {

struct DebugRequest {
  std::vector<Aov> aovs;
  bool sheet = false;    // several, side by side
  bool targets = false;  // the layout's own targets, instead of AOVs
  std::string target{};  // one of them alone; empty: all
};

// "sheet" (all AOVs), "lights", AOV names by comma, "targets" or "target:NAME". `moving`: whether there is motion to
// show on the sheet. Throws Error(Usage).
DebugRequest parseDebug(std::string_view text, bool moving);

// The value of {aov} in the name of its picture.
std::string_view debugName(const DebugRequest& request);

// The picture of AOVs. Those of the frame must have the request's, and, to tell the background, ids.
Picture debugPicture(const DebugRequest& request, const FrameOutput& frame);
// The picture of targets.
Picture debugPicture(const DebugRequest& request, const RawGbuffer& gbuffer);

}  // namespace latelight::output
