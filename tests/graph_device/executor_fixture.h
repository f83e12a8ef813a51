// A device under validation with synchronization checks; any message fails the test. Also passes for test graphs.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "test_device.h"
#include "vk/device.h"

namespace latelight::graph {

class Executors : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    device = std::make_unique<vk::Device>(vk::DeviceOptions{.selector = test::testDevice(), .validation = true});
  }
  static void TearDownTestSuite() { device.reset(); }
  void TearDown() override { EXPECT_THAT(device->validationMessages(), testing::IsEmpty()); }

  static vk::BufferDesc bufferDesc(const char* name, VkDeviceSize size = 1024) { return {.size = size, .name = name}; }
  static vk::BufferDesc readbackDesc(VkDeviceSize size = 1024) {
    return {.size = size, .kind = vk::MemoryKind::Readback, .name = "readback"};
  }
  static vk::ImageDesc imageDesc(const char* name, uint32_t layers = 1) {
    return {.format = VK_FORMAT_R32_UINT, .width = 16, .height = 16, .layers = layers, .name = name};
  }
  static std::vector<uint32_t> contents(const vk::Buffer& buffer) {
    const uint32_t* words = buffer.as<uint32_t>();
    return {words, words + buffer.size() / sizeof(uint32_t)};
  }

  void fill(Graph& graph, const char* name, BufferId buffer, uint32_t value) {
    graph.pass(Stage::Post, name, {{buffer, Use::CopyTarget}}, [=, this](Context& c) {
      ran.push_back(name);
      vkCmdFillBuffer(c.get(), c.buffer(buffer).get(), 0, VK_WHOLE_SIZE, value);
    });
  }
  void copy(Graph& graph, const char* name, BufferId from, BufferId to) {
    graph.pass(Stage::Post, name, {{from, Use::CopySource}, {to, Use::CopyTarget}}, [=, this](Context& c) {
      ran.push_back(name);
      const VkBufferCopy region{0, 0, c.buffer(to).size()};
      vkCmdCopyBuffer(c.get(), c.buffer(from).get(), c.buffer(to).get(), 1, &region);
    });
  }
  void copy(Graph& graph, const char* name, ImageId from, BufferId to) {
    graph.pass(Stage::Post, name, {{from, Use::CopySource}, {to, Use::CopyTarget}}, [=](Context& c) {
      const vk::ImageDesc& desc = c.image(from).desc();
      VkBufferImageCopy region{};
      region.imageSubresource = {c.image(from).aspect(), 0, 0, desc.layers};
      region.imageExtent = {desc.width, desc.height, 1};
      vkCmdCopyImageToBuffer(c.get(), c.image(from).get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, c.buffer(to).get(), 1,
                             &region);
    });
  }
  void clear(Graph& graph, const char* name, ImageId image, uint32_t value) {
    graph.pass(Stage::Post, name, {{image, Use::CopyTarget}}, [=](Context& c) {
      VkClearColorValue color{};
      color.uint32[0] = value;
      const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
      vkCmdClearColorImage(c.get(), c.image(image).get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &color, 1, &all);
    });
  }
  void run(Executor& executor, const Graph& graph) { executor.run(graph, graph.compile()); }

  inline static std::unique_ptr<vk::Device> device;
  std::vector<std::string> ran;
};

}  // namespace latelight::graph
