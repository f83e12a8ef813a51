// The Vulkan meaning of each Use: the only table from which barriers, layouts and usage flags are derived.
#pragma once

#include "graph/graph.h"

namespace latelight::graph {

struct UseInfo {
  const char* name;
  VkPipelineStageFlags2 stages;
  VkAccessFlags2 reading, writing;
  VkImageLayout layout;            // UNDEFINED: not usable for images
  VkImageUsageFlags imageUsage;    // required to create an image
  VkBufferUsageFlags bufferUsage;  // required to create a buffer, in addition to transfer and device address
  bool forBuffers;
  bool keeps;  // earlier contents are needed, or may partly be kept

  bool forImages() const { return layout != VK_IMAGE_LAYOUT_UNDEFINED; }
};
const UseInfo& useInfo(Use use);

// All uses of one resource in one pass, combined.
struct ResourceUse {
  VkPipelineStageFlags2 stages = 0;
  VkAccessFlags2 access = 0;  // reading and writing
  VkAccessFlags2 writing = 0;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;  // always UNDEFINED for buffers
  bool keeps = false;                                // one of the uses keeps earlier contents
  bool reads = false;                                // one of the uses reads, so contents must be defined

  void add(Use use, bool image);
};

}  // namespace latelight::graph
