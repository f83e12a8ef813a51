// A small model of Vulkan's memory, written from chapter 7 of the specification and independent of src/graph. It
// executes a plan access by access and reports errors. It is stricter than Vulkan in one respect: a barrier orders only
// its own resource, so that the barrier of another resource cannot conceal a missing one.
#pragma once

#include <string>
#include <vector>

#include "graph/graph.h"

namespace latelight::graph {

struct Resource {
  ImageId image;
  BufferId buffer;
  bool imported = false;
  std::vector<Use> before, exported;  // at most one element each
  // Ranges of memory that other resources use before and after; empty if the resource does not share memory.
  uint64_t begin = 0, end = 0;
};

struct ModelPass {
  std::vector<Access> accesses;
};

// Returns the errors of the plan, each in a few words; empty if it is valid.
std::vector<std::string> findHazards(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                     const Plan& plan);

// Returns the errors between resources that share bytes: two that are in use at once, or one that begins before the
// other has ended. Only the barriers before the first use of the later one count.
std::vector<std::string> findAliasingHazards(const std::vector<Resource>& resources,
                                             const std::vector<ModelPass>& passes, const Plan& plan);

// Returns the exported contents as hashes of all their inputs, if the listed passes run in this order.
std::vector<uint64_t> exportedValues(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                     const std::vector<uint32_t>& order);

}  // namespace latelight::graph
