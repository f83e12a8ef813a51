// Memory aliasing of transients on the CPU device.
#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/memory.h"
#include "executor_fixture.h"

namespace latelight::graph {
namespace {

using testing::Contains;
using testing::HasSubstr;

class SharedMemory : public Executors {
 protected:
  // Extends all lifetimes to the full plan, so that no resources share memory.
  static Plan withoutSharing(Plan plan) {
    for (Plan::Lifetime& life : plan.lives) {
      life.first = 0;
      life.last = static_cast<uint32_t>(plan.steps.size());
    }
    return plan;
  }
  static void forgetWhatWasThere(Plan& plan) {
    for (Plan::Lifetime& life : plan.lives) {
      life.lastStages = 0;
      life.lastWrites = 0;
    }
  }
  // The version of Vulkan that the validation layer knows; 0 if it is not installed.
  static uint32_t layerVersion() {
    uint32_t count = 0;
    VK_CHECK(vkEnumerateInstanceLayerProperties(&count, nullptr));
    std::vector<VkLayerProperties> layers(count);
    VK_CHECK(vkEnumerateInstanceLayerProperties(&count, layers.data()));
    const auto isValidation = [](const VkLayerProperties& layer) {
      return std::string_view(layer.layerName) == "VK_LAYER_KHRONOS_validation";
    };
    const auto found = std::ranges::find_if(layers, isValidation);
    return found == layers.end() ? 0 : found->specVersion;
  }
  uint64_t usedBytes() const { return device->memory().statistics().usedBytes; }

  // Alternating images and buffers, each computed from the previous one and its own number.
  BufferId addChain(Graph& graph, uint32_t length) {
    const BufferId out = graph.create(readbackDesc(1024 * length));
    BufferId before = graph.create(bufferDesc("first"));
    fill(graph, "fill", before, 1000);
    for (uint32_t i = 0; i < length; ++i) {
      const ImageId image = graph.create(imageDesc("image"));
      clear(graph, "clear", image, i);
      graph.pass(Stage::Post, "into half", {{before, Use::CopySource}, {image, Use::CopyTarget}}, [=](Context& c) {
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {16, 8, 1};
        region.imageOffset = {0, i % 2 ? 8 : 0, 0};
        vkCmdCopyBufferToImage(c.get(), c.buffer(before).get(), c.image(image).get(),
                               VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
      });
      before = graph.create(bufferDesc("buffer"));
      copy(graph, "out of it", image, before);
      graph.pass(Stage::Post, "keep", {{before, Use::CopySource}, {out, Use::CopyTarget}}, [=](Context& c) {
        const VkBufferCopy region{0, 1024 * i, 1024};
        vkCmdCopyBuffer(c.get(), c.buffer(before).get(), c.buffer(out).get(), 1, &region);
      });
    }
    graph.exports(out, Use::HostRead);
    return out;
  }
};

TEST_F(SharedMemory, GivesTheSameBytesInLessMemory) {
  Graph graph;
  const BufferId out = addChain(graph, 12);
  const Plan plan = graph.compile();
  Executor sharing(*device), plain(*device);
  const uint64_t start = usedBytes();
  plain.run(graph, withoutSharing(plan));
  const uint64_t afterPlain = usedBytes();
  sharing.run(graph, plan);
  const uint64_t afterSharing = usedBytes();
  EXPECT_EQ(contents(sharing.buffer(out)), contents(plain.buffer(out)));
  const std::vector<uint32_t> words = contents(plain.buffer(out));
  EXPECT_EQ(words[256 * 11], 11u);       // its own half
  EXPECT_EQ(words[256 * 11 + 255], 9u);  // the upper half of the previous one, which comes from the one before that

  // The expected sizes. Both executors allocated the same besides the transients.
  const TransientBytes bytes = transientBytes(*device, graph, plan);
  EXPECT_EQ((afterPlain - start) - (afterSharing - afterPlain), bytes.withoutAliasing - bytes.peak);
  EXPECT_EQ(transientBytes(*device, graph, withoutSharing(plan)).peak, bytes.withoutAliasing);
  const uint64_t outBytes = 12 * 1024;  // is exported, and shares memory with no other resource
  EXPECT_GE(bytes.peak, outBytes + 2 * 1024);
  EXPECT_LE(bytes.peak - outBytes, (bytes.withoutAliasing - outBytes) / 6);
}

TEST_F(SharedMemory, IsTheSameForEqualGraphs) {
  Executor executor(*device);
  std::set<VkImage> images;
  std::vector<Submission> submissions;
  const uint64_t start = usedBytes();
  for (uint32_t round = 0; round < 12; ++round) {
    Graph graph;
    const ImageId image = graph.create(imageDesc("image"));
    const BufferId out = graph.create(readbackDesc());
    clear(graph, "clear", image, round);
    graph.pass(Stage::Post, "look", {{image, Use::CopyTarget}},
               [&, image](Context& c) { images.insert(c.image(image).get()); });
    copy(graph, "read back", image, out);
    graph.exports(out, Use::HostRead);
    submissions.push_back(executor.submit(graph, graph.compile()));
    if (submissions.size() < Executor::kInFlight) continue;
    submissions.front().wait();
    EXPECT_THAT(contents(submissions.front().buffer(out)), testing::Each(round + 1 - Executor::kInFlight));
    submissions.erase(submissions.begin());
  }
  EXPECT_EQ(images.size(), 1u) << "submissions in flight have it in turn";
  // One image; results and timestamps of the submissions in flight, and of one that is read.
  EXPECT_LE(usedBytes() - start, 1024 + (Executor::kInFlight + 1) * (1024 + 512));
}

// Graphs of equal sizes that alternate use the same memory, which is freed with the graphs.
TEST_F(SharedMemory, IsSharedByGraphsInTurn) {
  const auto run = [&](Executor& executor, uint32_t rows) {
    Graph graph;
    vk::ImageDesc desc = imageDesc("image");
    desc.width = 512;
    desc.height = rows;
    const ImageId image = graph.create(desc);
    const BufferId out = graph.create(readbackDesc(512 * rows * 4));
    clear(graph, "clear", image, rows);
    copy(graph, "read back", image, out);
    graph.exports(out, Use::HostRead);
    executor.run(graph, graph.compile());
    EXPECT_THAT(contents(executor.buffer(out)), testing::Each(rows));
  };
  Executor executor(*device);
  const uint64_t start = usedBytes();
  run(executor, 512);
  const uint64_t large = usedBytes() - start;
  run(executor, 500);
  EXPECT_LT(usedBytes() - start, large + 512 * 500 * 4 + 4096) << "another result, but not another image";
  for (int i = 0; i < 6; ++i) run(executor, 16);
  EXPECT_LT(usedBytes() - start, large / 4);
}

// Returns the number of bytes that can still be allocated.
uint64_t claimable() {
  uint64_t bytes = 0;
  for (uint64_t step = uint64_t{1} << 42; step > 0; step /= 2) {
    try {
      const MemoryClaim claim(bytes + step, "a test");
      bytes += step;
    } catch (const Error&) {
    }
  }
  return bytes;
}

// The limit suffices for the transients of one graph, but not for two.
TEST_F(SharedMemory, MakesRoomForOthersWhereThereIsNoneLeft) {
  constexpr uint64_t kMiB = 1 << 20;
  Executor executor(*device);
  const auto run = [&](uint64_t mebibytes) {
    Graph graph;
    const BufferId large = graph.create(bufferDesc("large", mebibytes * kMiB)), out = graph.create(readbackDesc());
    graph.pass(Stage::Post, "write", {{large, Use::CopyTarget}}, [=](Context& c) {
      vkCmdFillBuffer(c.get(), c.buffer(large).get(), 0, 1024, static_cast<uint32_t>(mebibytes));
    });
    copy(graph, "read", large, out);
    graph.exports(out, Use::HostRead);
    executor.run(graph, graph.compile());
    EXPECT_THAT(contents(executor.buffer(out)), testing::Each(mebibytes));
  };
  run(150);
  const MemoryClaim others(claimable() - 30 * kMiB, "a test");
  run(60);
  run(150);
  EXPECT_THROW(run(200), Error);
  run(60);
}

// The second resource is written while the first is still read. The validation layers know that two buffers share
// memory, and those before 1.4 that two images do. They do not for a buffer and an image; the tests of plans check
// those barriers.
class MissingBarrier : public SharedMemory, public testing::WithParamInterface<bool> {};

TEST_P(MissingBarrier, IsCaught) {
  Graph graph;
  const BufferId outs[] = {graph.create(readbackDesc()), graph.create(readbackDesc())};
  for (const BufferId out : outs) {
    if (GetParam()) {
      const ImageId image = graph.create(imageDesc("image"));
      clear(graph, "clear", image, 1);
      copy(graph, "read", image, out);
    } else {
      const BufferId buffer = graph.create(bufferDesc("buffer"));
      fill(graph, "fill", buffer, 1);
      copy(graph, "read", buffer, out);
    }
    graph.exports(out, Use::HostRead);
  }
  Plan plan = graph.compile();
  const TransientBytes bytes = transientBytes(*device, graph, plan);
  ASSERT_EQ(bytes.withoutAliasing - bytes.peak, 1024u);
  Executor executor(*device);
  executor.run(graph, plan);
  ASSERT_THAT(device->validationMessages(), testing::IsEmpty());
  if (GetParam() && layerVersion() >= VK_MAKE_API_VERSION(0, 1, 4, 0))
    GTEST_SKIP() << "the layer does not know that images share memory";
  forgetWhatWasThere(plan);
  executor.run(graph, plan);
  EXPECT_THAT(device->validationMessages(), Contains(testing::ContainsRegex("WRITE.AFTER.READ")));
}
INSTANTIATE_TEST_SUITE_P(Of, MissingBarrier, testing::Bool(),
                         [](const auto& info) { return info.param ? "Images" : "Buffers"; });

}  // namespace
}  // namespace latelight::graph
