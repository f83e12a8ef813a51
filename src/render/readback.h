// How results of a graph come to the host.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/pass.h"

namespace latelight::render {

// A buffer for passes to leave a result in: device memory, which on a CPU device the host can read.
graph::BufferId createResult(const Builder& b, const std::string& name, uint64_t bytes);

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
