// The executor on the CPU device.
#include <algorithm>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>

#include "base/error.h"
#include "executor_fixture.h"
#include "vk/gate.h"

namespace latelight::graph {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(Executors, RunAChainOfBuffers) {
  Executor executor(*device);
  Graph graph;
  const BufferId a = graph.create(bufferDesc("a")), b = graph.create(bufferDesc("b"));
  const BufferId unused = graph.create(bufferDesc("unused")), out = graph.create(readbackDesc());
  fill(graph, "fill", a, 0x01020304);
  copy(graph, "copy", a, b);
  fill(graph, "culled", unused, 1);
  fill(graph, "refill", a, 0x0a0b0c0d);  // write after read
  copy(graph, "read back", b, out);
  graph.exports(out, Use::HostRead);
  graph.exports(a, Use::CopySource);
  run(executor, graph);
  EXPECT_THAT(ran, ElementsAre("fill", "copy", "refill", "read back"));
  EXPECT_THAT(contents(executor.buffer(out)), Each(0x01020304u));
  EXPECT_THROW(executor.buffer(unused), Error);
}

TEST_F(Executors, RunAChainOfImagesWithLayers) {
  Executor executor(*device);
  Graph graph;
  constexpr uint32_t kLayers = 3;
  const ImageId first = graph.create(imageDesc("first", kLayers)), second = graph.create(imageDesc("second", kLayers));
  const BufferId out = graph.create(readbackDesc(16 * 16 * 4 * kLayers));
  clear(graph, "clear", first, 77);
  clear(graph, "clear second", second, 5);
  graph.pass(Stage::Post, "copy the middle layer", {{first, Use::CopySource}, {second, Use::CopyTarget}},
             [=](Context& c) {
               VkImageCopy region{};
               region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 1};
               region.extent = {16, 16, 1};
               vkCmdCopyImage(c.get(), c.image(first).get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                              c.image(second).get(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
             });
  copy(graph, "read back", second, out);
  graph.exports(out, Use::HostRead);
  run(executor, graph);
  const std::vector<uint32_t> words = contents(executor.buffer(out));
  for (size_t i = 0; i < words.size(); ++i) ASSERT_EQ(words[i], i / 256 == 1 ? 77u : 5u) << "texel " << i;
}

void render(Context& c, const vk::Image* color, const vk::Image* depth, VkImageLayout depthLayout,
            VkAttachmentLoadOp load, const std::function<void()>& draw) {
  VkRenderingAttachmentInfo attachments[2] = {{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO},
                                              {VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO}};
  attachments[0].imageView = color ? color->view() : VK_NULL_HANDLE;
  attachments[0].imageLayout = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  attachments[0].loadOp = load;
  attachments[0].storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  attachments[0].clearValue.color.uint32[0] = 3;
  attachments[1].imageView = depth ? depth->view() : VK_NULL_HANDLE;
  attachments[1].imageLayout = depthLayout;
  const bool tested = depthLayout == VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL;
  attachments[1].loadOp = tested ? VK_ATTACHMENT_LOAD_OP_LOAD : VK_ATTACHMENT_LOAD_OP_CLEAR;
  attachments[1].storeOp = tested ? VK_ATTACHMENT_STORE_OP_NONE : VK_ATTACHMENT_STORE_OP_STORE;
  attachments[1].clearValue.depthStencil.depth = 0.25f;
  VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
  info.renderArea.extent = {16, 16};
  info.layerCount = 1;
  info.colorAttachmentCount = color ? 1 : 0;
  info.pColorAttachments = attachments;
  info.pDepthAttachment = depth ? &attachments[1] : nullptr;
  vkCmdBeginRendering(c.get(), &info);
  draw();
  vkCmdEndRendering(c.get());
}

TEST_F(Executors, GiveAttachmentsTheLayoutsTheyNeed) {
  Executor executor(*device);
  Graph graph;
  const ImageId color = graph.create(imageDesc("color"));
  vk::ImageDesc depthDesc = imageDesc("depth");
  depthDesc.format = VK_FORMAT_D32_SFLOAT;
  const ImageId depth = graph.create(depthDesc);
  const BufferId colorOut = graph.create(readbackDesc()), depthOut = graph.create(readbackDesc());
  constexpr VkImageLayout kAttachment = VK_IMAGE_LAYOUT_ATTACHMENT_OPTIMAL;
  graph.pass(Stage::Post, "geometry", {{color, Use::ColorAttachment}, {depth, Use::DepthAttachment}}, [=](Context& c) {
    render(c, &c.image(color), &c.image(depth), kAttachment, VK_ATTACHMENT_LOAD_OP_CLEAR, [] {});
  });
  graph.pass(Stage::Post, "over", {{color, Use::ColorAttachmentLoad}, {depth, Use::DepthTest}}, [=](Context& c) {
    render(c, &c.image(color), &c.image(depth), VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL, VK_ATTACHMENT_LOAD_OP_LOAD, [&] {
      VkClearAttachment upper{VK_IMAGE_ASPECT_COLOR_BIT, 0, {}};
      upper.clearValue.color.uint32[0] = 9;
      const VkClearRect rows{{{0, 0}, {16, 8}}, 0, 1};
      vkCmdClearAttachments(c.get(), 1, &upper, 1, &rows);
    });
  });
  copy(graph, "read color", color, colorOut);
  copy(graph, "read depth", depth, depthOut);
  graph.exports(colorOut, Use::HostRead);
  graph.exports(depthOut, Use::HostRead);
  run(executor, graph);
  const std::vector<uint32_t> words = contents(executor.buffer(colorOut));
  for (size_t i = 0; i < words.size(); ++i) ASSERT_EQ(words[i], i < 128 ? 9u : 3u) << "texel " << i;
  EXPECT_THAT(contents(executor.buffer(depthOut)), Each(0x3e800000u));  // 0.25f
}

TEST_F(Executors, ReadImportedImagesAndBringThemBack) {
  Executor executor(*device);
  vk::ImageDesc desc = imageDesc("texture");
  desc.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  const vk::Image texture(*device, desc);
  {
    vk::Uploader uploader(*device);
    const std::vector<uint32_t> texels(256, 1234);
    uploader.upload(texture, std::as_bytes(std::span(texels)));
  }
  for (int round = 0; round < 2; ++round) {
    Graph graph;
    const ImageId imported = graph.import(texture, Use::SampledFragment);
    const BufferId out = graph.create(readbackDesc());
    copy(graph, "read back", imported, out);
    graph.exports(out, Use::HostRead);
    run(executor, graph);
    EXPECT_THAT(contents(executor.buffer(out)), Each(1234u));
    EXPECT_EQ(&executor.image(imported), &texture);
  }
}

TEST_F(Executors, KeepTransientResourcesFromRunToRun) {
  Executor executor(*device);
  const auto frame = [&](uint32_t width, const auto& look) {
    Graph graph;
    vk::ImageDesc desc = imageDesc("color");
    desc.width = width;
    // Of equal size and in use at once, so they must not share memory.
    const ImageId one = graph.create(desc), two = graph.create(desc);
    const BufferId out = graph.create(readbackDesc(width * 16 * 4));
    clear(graph, "one", one, 1);
    clear(graph, "two", two, 2);
    VkImage first = VK_NULL_HANDLE;
    graph.pass(Stage::Post, "look", {{one, Use::CopySource}, {out, Use::CopyTarget}},
               [&, one](Context& c) { first = c.image(one).get(); });
    copy(graph, "read back", one, out);
    graph.exports(out, Use::HostRead);
    graph.exports(two, Use::CopySource);
    run(executor, graph);
    EXPECT_THAT(contents(executor.buffer(out)), Each(1u));
    EXPECT_NE(first, executor.image(two).get());
    look(executor.image(two).get(), executor.buffer(out).get());
  };
  VkImage image = VK_NULL_HANDLE;
  VkBuffer buffer = VK_NULL_HANDLE;
  frame(16, [&](VkImage i, VkBuffer b) {
    image = i;
    buffer = b;
  });
  const auto same = [&](VkImage i, VkBuffer b) {
    EXPECT_EQ(i, image);
    EXPECT_EQ(b, buffer);
  };
  frame(16, same);
  frame(32, [&](VkImage i, VkBuffer) { EXPECT_NE(i, image); });
  frame(16, same);
  // Memory that no submission uses any more is freed.
  const auto usedBytes = [&] { return device->memory().statistics().usedBytes; };
  const uint64_t withSmall = usedBytes();
  for (int i = 0; i < 6; ++i) frame(32, [](VkImage, VkBuffer) {});
  const uint64_t largeOnly = usedBytes();
  EXPECT_LT(largeOnly, withSmall);
  for (int i = 0; i < 6; ++i) frame(32, [](VkImage, VkBuffer) {});
  EXPECT_EQ(usedBytes(), largeOnly);
}

TEST_F(Executors, HaveSeveralSubmissionsInFlight) {
  Executor executor(*device);
  vk::Gate gate(*device);
  gate.close();
  std::vector<Submission> submissions;
  std::vector<BufferId> outs;
  for (uint32_t i = 0; i < Executor::kInFlight; ++i) {
    Graph graph;
    const BufferId a = graph.create(bufferDesc("a"));
    outs.push_back(graph.create(readbackDesc()));
    fill(graph, "fill", a, 100 + i);
    copy(graph, "read back", a, outs.back());
    graph.exports(outs.back(), Use::HostRead);
    submissions.push_back(executor.submit(graph, graph.compile()));
  }
  for (const Submission& submission : submissions) EXPECT_FALSE(submission.done());
  gate.open();
  submissions.back().wait();
  for (uint32_t i = 0; i < submissions.size(); ++i) {
    EXPECT_TRUE(submissions[i].done());
    EXPECT_THAT(contents(submissions[i].buffer(outs[i])), Each(100 + i));
    EXPECT_EQ(submissions[i].times().size(), 2u);
  }
}

TEST_F(Executors, SubmitRecordedGraphsAgain) {
  Executor executor(*device);
  const vk::Buffer data(*device, {.size = 1024, .kind = vk::MemoryKind::Upload, .name = "data"});
  Graph graph;
  const BufferId in = graph.import(data, std::nullopt), a = graph.create(bufferDesc("a"));
  const BufferId out = graph.create(readbackDesc());
  copy(graph, "copy", in, a);
  copy(graph, "read back", a, out);
  graph.exports(out, Use::HostRead);
  const std::shared_ptr<RecordedGraph> recorded = executor.record(graph, graph.compile());
  EXPECT_THAT(ran, ElementsAre("copy", "read back"));
  const auto allocations = [&] { return device->memory().statistics().allocations; };
  const size_t before = allocations();
  for (uint32_t value = 1; value < 4; ++value) {
    ASSERT_TRUE(executor.isIdle(recorded));
    std::fill_n(data.as<uint32_t>(), 256, value);
    const Submission done = executor.submit(recorded);
    done.wait();
    EXPECT_THAT(contents(done.buffer(out)), Each(value));
    EXPECT_EQ(done.times().size(), 2u);
    EXPECT_FALSE(executor.isIdle(recorded)) << "its results are in use";
    EXPECT_THROW(static_cast<void>(done.buffer(a)), Error);
  }
  EXPECT_EQ(ran.size(), 2u) << "passes ran once";
  EXPECT_EQ(allocations(), before);
}

// The results of a request of many submissions are released together, and taken again by the next one.
TEST_F(Executors, KeepResultsOfManySubmissions) {
  Executor executor(*device);
  std::vector<Submission> held;
  size_t first = 0;
  for (int request = 0; request < 4; ++request) {
    held.clear();
    for (int i = 0; i < 12; ++i) {
      Graph graph;
      const BufferId out = graph.create(bufferDesc("result", 4096));
      fill(graph, "fill", out, 1);
      graph.exports(out, Use::CopySource);
      held.push_back(executor.submit(graph, graph.compile()));
      held.back().wait();
    }
    if (request == 0) first = device->memory().statistics().allocations;
    EXPECT_EQ(device->memory().statistics().allocations, first);
  }
}

// Runs without validation: where a signal by the host lets another thread's wait return before the signaling call has,
// layer 1.3.239 waits ten seconds for itself and then reports "most likely a validation bug".
TEST_F(Executors, WaitForTheOldestWhereTooManyAreInFlight) {
  vk::Device unchecked({.selector = test::testDevice()});
  Executor executor(unchecked);
  const auto submit = [&](uint32_t value, const std::function<void(VkCommandBuffer)>& recorded) {
    Graph graph;
    const BufferId out = graph.create(readbackDesc());
    graph.pass(Stage::Post, "first", {{out, Use::CopyTarget}}, [&](Context& c) { recorded(c.get()); });
    fill(graph, "fill", out, value);
    graph.exports(out, Use::HostRead);
    return std::pair(executor.submit(graph, graph.compile()), out);
  };
  vk::Gate gate(unchecked);
  gate.close();
  std::vector<std::pair<Submission, BufferId>> all;
  const auto oldestIsDone = [&] { EXPECT_TRUE(all[all.size() - Executor::kInFlight].first.done()); };
  for (uint32_t i = 0; i < Executor::kInFlight; ++i) all.push_back(submit(i, [](VkCommandBuffer) {}));
  std::thread opener([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    gate.open();
  });
  for (uint32_t i = Executor::kInFlight; i < 20; ++i)
    all.push_back(submit(i, [&](VkCommandBuffer) { oldestIsDone(); }));
  opener.join();
  for (uint32_t i = 0; i < all.size(); ++i) {
    all[i].first.wait();
    EXPECT_THAT(contents(all[i].first.buffer(all[i].second)), Each(i)) << "each keeps its own";
  }
}

TEST_F(Executors, GiveResultsToOthersOnceTheyAreDropped) {
  Executor executor(*device);
  const auto submit = [&](Submission& submission) {
    Graph graph;
    const BufferId out = graph.create(readbackDesc());
    fill(graph, "fill", out, 1);
    graph.exports(out, Use::HostRead);
    submission = executor.submit(graph, graph.compile());
    return submission.buffer(out).get();
  };
  Submission a, b;
  const VkBuffer first = submit(a), second = submit(b);
  EXPECT_NE(first, second);
  a.wait();
  a = Submission();
  EXPECT_EQ(submit(a), first);
  // A submission that is destroyed in flight keeps its resources until it has finished.
  vk::Gate gate(*device);
  gate.close();
  Graph held;
  const BufferId out = held.create(readbackDesc());
  fill(held, "fill", out, 1);
  held.exports(out, Use::HostRead);
  const VkBuffer busy = executor.submit(held, held.compile()).buffer(out).get();
  Submission c;
  EXPECT_NE(submit(c), busy);
  gate.open();
  c.wait();
  Submission d;
  EXPECT_EQ(submit(d), busy);
}

TEST_F(Executors, LeaveResultsToSubmissionsThatOutliveThem) {
  Submission submission;
  BufferId out;
  vk::Gate gate(*device);
  gate.close();
  {
    Executor executor(*device);
    Graph graph;
    const BufferId a = graph.create(bufferDesc("a"));
    out = graph.create(readbackDesc());
    fill(graph, "fill", a, 12);
    copy(graph, "read back", a, out);
    graph.exports(out, Use::HostRead);
    submission = executor.submit(graph, graph.compile());
    executor.submit(graph, graph.compile());  // destroyed in flight, with its executor
  }
  EXPECT_FALSE(submission.done());
  gate.open();
  EXPECT_EQ(submission.times().size(), 2u);
  EXPECT_THAT(contents(submission.buffer(out)), Each(12u));
}

// This would wait forever if a result became available only after a later submission.
TEST_F(Executors, GiveResultsWhileLaterSubmissionsRun) {
  Executor executor(*device);
  vk::Gate gate(*device);
  Graph graph, later;
  const BufferId out = graph.create(readbackDesc()), a = later.create(bufferDesc("a"));
  fill(graph, "fill", out, 3);
  graph.exports(out, Use::HostRead);
  fill(later, "fill", a, 4);
  later.exports(a, Use::CopySource);
  const Submission submission = executor.submit(graph, graph.compile());
  gate.close();
  const Submission held = executor.submit(later, later.compile());
  EXPECT_EQ(submission.times().size(), 1u);
  EXPECT_THAT(contents(submission.buffer(out)), Each(3u));
  EXPECT_FALSE(held.done());
}

TEST_F(Executors, LeaveResultsToAnotherThread) {
  Executor executor(*device);
  std::vector<std::future<void>> readers;
  for (uint32_t i = 0; i < 50; ++i) {
    Graph graph;
    const BufferId a = graph.create(bufferDesc("a")), out = graph.create(readbackDesc());
    fill(graph, "fill", a, i);
    copy(graph, "read back", a, out);
    graph.exports(out, Use::HostRead);
    const auto read = [i, out](Submission submission) {
      submission.wait();
      EXPECT_THAT(contents(submission.buffer(out)), Each(i));
      EXPECT_EQ(submission.times().size(), 2u);
    };
    readers.push_back(std::async(std::launch::async, read, executor.submit(graph, graph.compile())));
  }
  for (std::future<void>& reader : readers) reader.get();
}

TEST_F(Executors, GiveNoResultsOfNothing) {
  const Submission nothing;
  EXPECT_TRUE(nothing.done());
  nothing.wait();
  EXPECT_THAT(nothing.times(), IsEmpty());
  EXPECT_THROW(nothing.buffer(BufferId{0}), Error);
  EXPECT_THROW(nothing.image(ImageId{0}), Error);
}

TEST_F(Executors, TimeEachPassThatRan) {
  Executor executor(*device);
  Graph graph;
  const BufferId a = graph.create(bufferDesc("a", 16 << 20)), b = graph.create(bufferDesc("b", 16 << 20));
  const BufferId unused = graph.create(bufferDesc("unused"));
  fill(graph, "fill", a, 1);
  fill(graph, "culled", unused, 1);
  copy(graph, "copy", a, b);
  graph.exports(b, Use::CopySource);
  EXPECT_THAT(executor.times(), IsEmpty());
  for (int round = 0; round < 2; ++round) {
    const auto start = std::chrono::steady_clock::now();
    run(executor, graph);
    const std::chrono::duration<double, std::milli> all = std::chrono::steady_clock::now() - start;
    ASSERT_EQ(executor.times().size(), 2u);
    EXPECT_EQ(executor.times()[0].name, "fill");
    EXPECT_EQ(executor.times()[1].name, "copy");
    for (const PassTime& time : executor.times()) EXPECT_GT(time.milliseconds, 0) << time.name;
    EXPECT_LT(executor.times()[0].milliseconds + executor.times()[1].milliseconds, all.count());
  }
}

// A buffer that no graph knows, filled and read with only the prologue's barrier.
TEST_F(Executors, RunThePrologueFirstAndMakeItSeen) {
  Executor executor(*device);
  const vk::Buffer scene(*device, bufferDesc("scene")), copied(*device, bufferDesc("copied"));
  const auto copyAll = [](VkCommandBuffer commands, const vk::Buffer& from, const vk::Buffer& to) {
    const VkBufferCopy region{0, 0, 1024};
    vkCmdCopyBuffer(commands, from.get(), to.get(), 1, &region);
  };
  Graph graph;
  const BufferId out = graph.create(readbackDesc());
  graph.pass(Stage::Output, "read back", {{out, Use::CopyTarget}},
             [&](Context& c) { copyAll(c.get(), copied, c.buffer(out)); });
  graph.prologue(Stage::Upload, "upload",
                 [&](Context& c) { vkCmdFillBuffer(c.get(), scene.get(), 0, VK_WHOLE_SIZE, 21); });
  graph.prologue(Stage::Deformation, "deform", [&](Context& c) { copyAll(c.get(), scene, copied); });
  graph.prologue(Stage::Upload, "upload more",
                 [&](Context& c) { vkCmdFillBuffer(c.get(), scene.get(), 0, VK_WHOLE_SIZE, 22); });
  graph.exports(out, Use::HostRead);
  run(executor, graph);
  EXPECT_THAT(contents(executor.buffer(out)), Each(21u));
  std::vector<std::string> names;
  for (const PassTime& time : executor.times()) names.push_back(time.name);
  EXPECT_THAT(names, ElementsAre("upload", "deform", "upload more", "read back"));
  EXPECT_EQ(executor.times()[1].stage, Stage::Deformation);

  Plan plan = graph.compile();
  plan.steps.at(1).before.clear();
  executor.run(graph, plan);
  EXPECT_THAT(device->validationMessages(), testing::Contains(testing::ContainsRegex("READ.AFTER.WRITE")));
}

TEST_F(Executors, TimeMorePassesThanBefore) {
  Executor executor(*device);
  for (const int passes : {1, 40, 100, 3}) {
    Graph graph;
    const BufferId a = graph.create(bufferDesc("a"));
    for (int i = 0; i < passes; ++i) fill(graph, "fill", a, i);
    graph.exports(a, Use::CopySource);
    run(executor, graph);
    EXPECT_EQ(executor.times().size(), static_cast<size_t>(passes));
  }
}

TEST_F(Executors, PassOnWhatAPassThrowsAndWorkAfter) {
  Executor executor(*device);
  Graph broken;
  const BufferId a = broken.create(bufferDesc("a"));
  broken.pass(Stage::Post, "throws", {{a, Use::CopyTarget}}, [](Context&) { throw std::runtime_error("no"); });
  broken.exports(a, Use::CopySource);
  EXPECT_THROW(run(executor, broken), std::runtime_error);
  EXPECT_THAT(executor.times(), IsEmpty());

  Graph graph;
  const BufferId out = graph.create(readbackDesc());
  fill(graph, "fill", out, 4);
  graph.exports(out, Use::HostRead);
  run(executor, graph);
  EXPECT_THAT(contents(executor.buffer(out)), Each(4u));
}

TEST_F(Executors, RefuseResourcesThatNoPassDeclared) {
  Executor executor(*device);
  Graph graph;
  const BufferId a = graph.create(bufferDesc("a")), undeclared = graph.create(bufferDesc("undeclared"));
  graph.pass(Stage::Post, "asks", {{a, Use::CopyTarget}}, [=](Context& c) { c.buffer(undeclared); });
  graph.exports(a, Use::CopySource);
  EXPECT_THROW(run(executor, graph), Error);
}

// Otherwise other passes would decide whether this pass runs.
TEST_F(Executors, RefuseResourcesThatOnlyAnotherPassDeclared) {
  Executor executor(*device);
  Graph graph;
  const BufferId a = graph.create(bufferDesc("a")), b = graph.create(bufferDesc("b"));
  fill(graph, "fills", b, 1);
  graph.pass(Stage::Post, "asks", {{a, Use::CopyTarget}}, [=](Context& c) { c.buffer(b); });
  graph.exports(a, Use::CopySource);
  graph.exports(b, Use::CopySource);
  EXPECT_THROW(run(executor, graph), Error);
}

// Without this test, a missing validation layer would look like a run without errors.
TEST_F(Executors, AreCaughtWhenABarrierIsMissing) {
  Executor executor(*device);
  Graph graph;
  const BufferId a = graph.create(bufferDesc("a")), out = graph.create(readbackDesc());
  fill(graph, "fill", a, 1);
  copy(graph, "read back", a, out);
  graph.exports(out, Use::HostRead);
  Plan plan = graph.compile();
  ASSERT_EQ(plan.steps.at(1).before.size(), 1u);
  plan.steps[1].before.clear();
  executor.run(graph, plan);
  EXPECT_THAT(device->validationMessages(), testing::Contains(testing::ContainsRegex("READ.AFTER.WRITE")));
}

}  // namespace
}  // namespace latelight::graph
