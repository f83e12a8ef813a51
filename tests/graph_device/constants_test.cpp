// Constants that the host writes while it builds a graph, and that a shader on the CPU device reads.
#include <numeric>

#include "base/error.h"
#include "executor_fixture.h"
#include "gpu_math/spirv.h"
#include "vk/gate.h"
#include "vk/pipeline.h"

namespace latelight::graph {
namespace {

using testing::Each;

class Constants : public Executors {
 protected:
  Constants()
      : pipeline(vk::makePipeline(
            *device, vk::ComputeDesc{.name = "read words", .code = test::readSpirv("graph_device_read_words")})) {}

  static std::vector<uint32_t> words(uint32_t first, size_t count = 256) {
    std::vector<uint32_t> result(count);
    std::iota(result.begin(), result.end(), first);
    return result;
  }
  // Adds the words to the graph, and a pass that copies them to the result.
  BufferId addReader(Graph& graph, const std::vector<uint32_t>& values) {
    const BufferId out = graph.create(readbackDesc(4 * values.size()));
    addReader(graph, values, out);
    return out;
  }
  void addReader(Graph& graph, const std::vector<uint32_t>& values, BufferId out) {
    const VkDeviceAddress from = graph.constants(std::as_bytes(std::span(values)));
    const uint32_t count = static_cast<uint32_t>(values.size());
    graph.pass(Stage::Output, "read", {{out, Use::StorageWrite}}, [=, this](Context& c) {
      const struct {
        VkDeviceAddress from, to;
        uint32_t count;
      } push{from, c.buffer(out).address(), count};
      c.commands().bind(pipeline, std::initializer_list<vk::BoundImage>{}, push);
      c.commands().dispatch(count, 1, 1, 64, 1);
    });
    graph.exports(out, Use::HostRead);
  }
  static vk::Allocator::Statistics memory() { return device->memory().statistics(); }

  vk::Pipeline pipeline;
};

TEST_F(Constants, AreReadByShaders) {
  Executor executor(*device);
  Graph graph(executor);
  std::vector<BufferId> outs;
  // Many sizes; the last one exceeds a chunk.
  const std::vector<size_t> sizes = {1, 3, 256, 5000, 20000, 7, 100000};
  for (const size_t size : sizes) outs.push_back(addReader(graph, words(static_cast<uint32_t>(size), size)));
  executor.run(graph, graph.compile());
  for (size_t i = 0; i < sizes.size(); ++i)
    EXPECT_EQ(contents(executor.buffer(outs[i])), words(static_cast<uint32_t>(sizes[i]), sizes[i]));
  // The same graph again, with more constants.
  outs.push_back(addReader(graph, words(77)));
  executor.run(graph, graph.compile());
  EXPECT_EQ(contents(executor.buffer(outs[2])), words(256));
  EXPECT_EQ(contents(executor.buffer(outs.back())), words(77));
}

TEST_F(Constants, LieAtAddressesForAnyStruct) {
  Executor executor(*device);
  Graph graph(executor);
  for (size_t size : {0, 1, 17, 4}) EXPECT_EQ(graph.constants(std::vector<std::byte>(size)) % 16, 0u);
}

// The graph is destroyed and other graphs write their constants before the shader reads.
TEST_F(Constants, StayUntilTheSubmissionHasFinished) {
  Executor executor(*device);
  vk::Gate gate(*device);
  gate.close();
  std::vector<Submission> submissions;
  std::vector<BufferId> outs;
  for (uint32_t i = 0; i < Executor::kInFlight; ++i) {
    Graph graph(executor);
    outs.push_back(addReader(graph, words(1000 * i)));
    submissions.push_back(executor.submit(graph, graph.compile()));
  }
  gate.open();
  for (uint32_t i = 0; i < outs.size(); ++i) {
    submissions[i].wait();
    EXPECT_EQ(contents(submissions[i].buffer(outs[i])), words(1000 * i));
  }
}

TEST_F(Constants, StayForGraphsThatAreSubmittedLater) {
  Executor executor(*device);
  Graph first(executor), second(executor);
  const BufferId a = addReader(first, words(1)), b = addReader(second, words(2));
  executor.run(second, second.compile());
  EXPECT_EQ(contents(executor.buffer(b)), words(2));
  for (uint32_t i = 0; i < 3; ++i) {
    Graph other(executor);
    addReader(other, words(9));
    executor.run(other, other.compile());
  }
  executor.run(first, first.compile());
  EXPECT_EQ(contents(executor.buffer(a)), words(1));
}

TEST_F(Constants, UseTheirMemoryAgain) {
  Executor executor(*device);
  uint64_t used = 0;
  for (uint32_t i = 0; i < 40; ++i) {
    Graph graph(executor);
    const BufferId out = addReader(graph, words(i));
    executor.run(graph, graph.compile());
    EXPECT_EQ(contents(executor.buffer(out)), words(i));
    if (i == 10) used = memory().usedBytes;
  }
  EXPECT_EQ(memory().usedBytes, used);
}

// Executor and submission are destroyed in flight, and a remaining graph adds constants.
TEST_F(Constants, OutliveTheirExecutor) {
  const vk::Buffer result(*device, readbackDesc());
  const std::vector<uint32_t> others = words(6);
  vk::Gate gate(*device);
  gate.close();
  auto executor = std::make_unique<Executor>(*device);
  Graph left(*executor);
  {
    Graph graph(*executor);
    addReader(graph, words(5), graph.import(result, std::nullopt));
    executor->submit(graph, graph.compile());
  }
  executor.reset();
  left.constants(std::as_bytes(std::span(others)));
  gate.open();
  device->submitAndWait([](VkCommandBuffer) {});
  EXPECT_EQ(contents(result), words(5));
}

TEST_F(Constants, NeedAnExecutor) {
  Graph graph;
  EXPECT_THROW(graph.constants({}), Error);
}

}  // namespace
}  // namespace latelight::graph
