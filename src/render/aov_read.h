// Data outputs: from the device's targets to what leaves, in the units and frames of docs/conventions.md.
#pragma once

#include <map>
#include <span>

#include "graph/graph.h"
#include "output/files.h"
#include "render/frame.h"
#include "render/settings.h"

namespace latelight::render {

// The linear picture: half floats, or (`isFloat`) 32-bit ones times `scale`.
void readColor(output::FrameOutput& to, const vk::Buffer& from, size_t view, bool isFloat, float scale);

// Aov::LightsTested and LightsUsed, which come from a frame that counts lights.
bool isLightCount(output::Aov aov);
void readLightCounts(output::FrameOutput& to, const vk::Buffer& from, size_t view);

// What comes from the layout `exact`: all but the picture, and what counts its cost.
bool isData(output::Aov aov);

// Aov::Samples, from a frame's surfaces of pixels, or, where it has none, from its depth.
void readSampleCounts(output::FrameOutput& to, const vk::Buffer& from, size_t view, bool surfaces);

// How often the pixels of pictures were shaded.
struct ShadingCounts {
  uint64_t pixels = 0;    // of the pictures
  uint64_t drawn = 0;     // of them, those that show anything
  uint64_t several = 0;   // and those that show several surfaces, so that they are shaded more than once
  uint64_t shadings = 0;  // of all pixels
};

// Of surfaces of pixels, added to `counts`.
void countShadings(ShadingCounts& counts, const vk::Buffer& surfaces, size_t pixels);

// The targets of the layout `exact` that these outputs lie in, a bit each.
uint32_t exactTargets(std::span<const output::Aov> aovs);

// Reads back the targets of the layout `exact` that the data outputs asked for need.
class DataReadback {
 public:
  // `motion`: the data of MotionPass, which Aov::Motion needs.
  DataReadback(graph::Graph& graph, const Layout& exact, const Gbuffer& gbuffer, graph::ImageId motion,
               std::span<const output::Aov> aovs);
  // Fills the AovImages of `to` except Color and the counts of lights. `yUp`: into glTF's frame.
  void read(const graph::Submission& done, const shared::View& view, size_t layer, const Settings& settings, bool yUp,
            output::FrameOutput& to) const;

 private:
  std::map<std::string, graph::BufferId> buffers_;  // by target; "depth" is the depth buffer
};

}  // namespace latelight::render
