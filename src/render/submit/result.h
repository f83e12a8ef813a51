// The results of a request.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "output/files.h"
#include "output/targets.h"
#include "render/outputs/exported.h"
#include "render/outputs/outputs.h"

namespace latelight::render {

// How the device rendered a request.
struct RenderStatistics {
  // GPU milliseconds per pass, summed over the frames of all pictures, in the order of the passes. Empty if the device
  // has no timestamps.
  std::vector<graph::PassTime> passTimes;
  // Requires several samples per pixel, a deferred technique, and Settings::countSurfaces.
  std::optional<ShadingCounts> shadingCounts;
  uint32_t replays = 0;  // graphs that submitted the recorded commands of an earlier request
  std::string graphviz;  // the last graph, in Graphviz format; requires Settings::describeGraph
};

struct RenderResult {
  std::vector<output::FrameOutput> frames;  // in the order of their cameras; empty for Results::Exported
  std::vector<ExportedArray> arrays;        // Results::Exported only: arrays of all pictures
  std::vector<uint32_t> worldStatus;        // kWorld* bits of each world that shaders placed
  RenderStatistics statistics;
};

struct TargetsResult {
  output::RawGbuffer gbuffer;
  RenderStatistics statistics;
};

}  // namespace latelight::render
