// Reads results of a graph back to the host.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "render/base/pass.h"

namespace latelight::render {

// Where a pass writes a result of some views: a separate buffer, or a part of a larger one.
struct ResultTarget {
  graph::BufferId buffer;
  graph::Use use = graph::Use::StorageWrite;
  uint64_t offset = 0;     // bytes: start of the first view
  uint64_t viewBytes = 0;  // bytes: stride between views

  VkDeviceAddress address(graph::Context& context) const { return context.buffer(buffer).address() + offset; }
};
// Creates a new buffer in device memory, which the host can read on a CPU device.
ResultTarget createResult(const Builder& b, const std::string& name, uint64_t viewBytes, size_t views);

// Adds a pass that fills a result, `viewBytes` in each of `views` views, with repetitions of a few 32-bit words.
void addFill(const Builder& b, const ResultTarget& result, uint64_t viewBytes, size_t views,
             const std::vector<uint32_t>& words);

// Keeps results of a graph on the device after it has run.
void storeResults(const Builder& b, std::span<const graph::BufferId> results);
// Copies the current contents of buffers to buffers that the host can read after the graph has run. Returns these in
// the same order.
std::vector<graph::BufferId> copyToHost(const Builder& b, graph::Stage stage, const char* name,
                                        const std::vector<graph::BufferId>& from);
// Makes results readable by the host after the graph has run. Returns the readable buffers in the same order.
std::vector<graph::BufferId> addReadback(const Builder& b, std::span<const graph::BufferId> results);
// The same for one result.
graph::BufferId addReadback(const Builder& b, graph::BufferId result);

// Copies an image (level 0, all layers, tightly packed) to a buffer that the host can read after the graph has run.
graph::BufferId addReadback(graph::Graph& graph, graph::ImageId image);

}  // namespace latelight::render
