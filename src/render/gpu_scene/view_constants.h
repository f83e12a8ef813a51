// Writes the constants of views of worlds on the device, so that the host's work does not depend on their number.
#pragma once

#include "graph/graph.h"
#include "render/gpu_scene/view_constants_push.h"

namespace latelight::render {

// Adds the pass to the prologue of a graph. `constants`: the address of shared::ViewConstants, which must be valid when
// the graph runs.
void addViewConstants(vk::Device& device, graph::Graph& graph, VkDeviceAddress constants, uint32_t views);

}  // namespace latelight::render
