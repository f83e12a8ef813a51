// How results of a graph come to the host.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/pass.h"

namespace latelight::render {

// Where a pass leaves a result of some views: in a buffer of its own, or in a part of a larger one.
struct ResultPlace {
  graph::BufferId buffer;
  graph::Use use = graph::Use::StorageWrite;
  uint64_t offset = 0;     // bytes: where the first view's begins
  uint64_t viewBytes = 0;  // from the beginning of one view's to that of the next

  VkDeviceAddress address(graph::Context& context) const { return context.buffer(buffer).address() + offset; }
};
// In a new buffer: device memory, which on a CPU device the host can read.
ResultPlace createResult(const Builder& b, const std::string& name, uint64_t viewBytes, size_t views);

// Keeps results of a graph after it has run, where they are.
void keepResults(const Builder& b, std::span<const graph::BufferId> results);
// Copies buffers as they are now to where the host can read them after the graph has run; gives them there, in their
// order.
std::vector<graph::BufferId> copyToHost(const Builder& b, graph::Stage stage, const char* name,
                                        const std::vector<graph::BufferId>& from);
// Brings results to where the host can read them after the graph has run; gives them there, in their order.
std::vector<graph::BufferId> addReadback(const Builder& b, std::span<const graph::BufferId> results);
// The same of one.
graph::BufferId addReadback(const Builder& b, graph::BufferId result);

// Copies a whole image (level 0, all layers, tightly packed) to a buffer the host can read after the run.
graph::BufferId addReadback(graph::Graph& graph, graph::ImageId image);

}  // namespace latelight::render
