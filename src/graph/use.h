// What each Use means to Vulkan: the one table that barriers, layouts and usage flags come from.
#pragma once

#include "graph/graph.h"

namespace latelight::graph {

struct UseInfo {
  const char* name;
  VkPipelineStageFlags2 stages;
  VkAccessFlags2 reading, writing;
  VkImageLayout layout;            // UNDEFINED: not for images
  VkImageUsageFlags imageUsage;    // what an image must be made with
  VkBufferUsageFlags bufferUsage;  // what a buffer must be made with, beside transfer and device address
  bool forBuffers;
  bool keeps;  // what was there before is needed, or may stay in part

  bool forImages() const { return layout != VK_IMAGE_LAYOUT_UNDEFINED; }
};
const UseInfo& useInfo(Use use);

// All uses that one pass makes of one resource, together.
struct Need {
  VkPipelineStageFlags2 stages = 0;
  VkAccessFlags2 access = 0;  // reading and writing
  VkAccessFlags2 writing = 0;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;  // of buffers: always
  bool keeps = false;                                // one of the uses keeps what was there before
  bool reads = false;                                // undefined contents would show

  void add(Use use, bool image);
};

}  // namespace latelight::graph
