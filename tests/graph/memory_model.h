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
  std::vector<Use> before, exported;  // one or none
  // Bytes of memory that others have too, before and after; none: memory of its own.
  uint64_t begin = 0, end = 0;
};

struct ModelPass {
  std::vector<Access> accesses;
};

// What is wrong with the plan, each in a few words; nothing if it is right.
std::vector<std::string> findHazards(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                     const Plan& plan);

// What is wrong between resources that share bytes: two at once, or one that comes before the other is over. Of the
// barriers of the one that comes, only those before its first use count.
std::vector<std::string> findAliasingHazards(const std::vector<Resource>& resources,
                                             const std::vector<ModelPass>& passes, const Plan& plan);

// The exported contents, as hashes of all that went into them, when the passes listed run in that order.
std::vector<uint64_t> exportedValues(const std::vector<Resource>& resources, const std::vector<ModelPass>& passes,
                                     const std::vector<uint32_t>& order);

}  // namespace latelight::graph
