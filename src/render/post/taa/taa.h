// Temporal anti-aliasing (TAA): each jittered frame of a sequence is blended into the history of earlier frames, which
// is reprojected with motion vectors (Karis 2014, High Quality Temporal Supersampling, SIGGRAPH; docs/taa.md).
#pragma once

#include <glm/vec2.hpp>
#include <vector>

#include "render/frame/frame_history.h"

namespace latelight::render {

// The number of frames averaged for a still picture and for the first picture of a sequence, and the length of the
// jitter cycle.
inline constexpr uint32_t kTemporalSamples = 16;

// Offsets from the pixel's center, in pixels: the Halton sequence in bases 2 and 3, minus its mean.
const std::vector<glm::vec2>& temporalJitters();

// Images of a frame. `motion` is that of MotionUse::Reproject.
struct TemporalSources {
  graph::ImageId picture, depth, motion;
};

// Returns a history without frames.
FrameHistory temporalHistory();

// Begins or continues a history, and returns the anti-aliased picture. To begin, `sources` has the sum of
// kTemporalSamples frames, with depth and motion of the last one, and the result is their mean. To continue, `sources`
// has a single frame.
graph::ImageId addTemporal(const FrameContext& f, const TemporalSources& sources, FrameHistory& history, bool begins);

}  // namespace latelight::render
