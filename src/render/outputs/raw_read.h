// Readback of a frame's G-buffer targets as stored, for images of them.
#pragma once

#include <vector>

#include "graph/graph.h"
#include "output/targets.h"
#include "render/frame/frame.h"

namespace latelight::render {

class RawReadback {
 public:
  // Reads back the layout's targets, the lit light accumulation target, and depth.
  RawReadback(graph::Graph& graph, const Layout& layout, uint32_t normalEncoding, const Gbuffer& gbuffer);
  // Returns the G-buffer of the first view.
  output::RawGbuffer read(const graph::Submission& done, const shared::View& view) const;

 private:
  struct Target {
    output::RawTarget described;  // without values
    VkFormat format;
    graph::BufferId buffer;
  };
  std::vector<Target> targets_;
  graph::BufferId depth_;
};

}  // namespace latelight::render
