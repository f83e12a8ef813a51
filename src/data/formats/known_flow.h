// Optical flow that is known: the output motion is 0 where the other frame's camera does not project the surface.
#pragma once

#include <vector>

#include "data/frame.h"
#include "output/aov.h"

namespace latelight::data {

enum class FlowTarget : uint8_t { Previous, Next };

// The outputs from which knownFlow() is computed.
std::vector<output::Aov> flowOutputs();

// Returns two values per pixel: the flow to the previous or the next frame in pixels, y down. They are NaN if there is
// no such frame, and where its camera does not project the pixel's surface, such as behind the camera. The motion of
// surfaces from the previous frame is assumed to be that to the next one.
std::vector<float> knownFlow(const DataFrame& frame, FlowTarget target);

}  // namespace latelight::data
