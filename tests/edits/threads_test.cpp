// Renderers of one scene on one device in several threads: they share pipelines, memory, the queue and its timeline,
// and their pictures equal those of one renderer after the other, to the byte.
#include <fmt/core.h>

#include <barrier>
#include <exception>
#include <thread>

#include "edits/workshop.h"

namespace latelight::render::test {
namespace {

constexpr uint32_t kThreads = 2, kRounds = 3;

// What a thread requests in a round. Both threads together cover both rasters, shadows, exact transparency, several
// samples, and several views at once.
struct Task {
  Settings settings = workshopSettings();
  std::vector<scene::Camera> cameras;
};

Task taskOf(uint32_t thread, uint32_t round) {
  Task task;
  Settings& s = task.settings;
  s.raster = (thread + round) % 2 ? Raster::Compute : Raster::Hardware;
  s.aa.superSampling = round == 1 ? 2 : 1;
  if (round == 2) s.height = 40 + 8 * thread;
  task.cameras.assign(1 + round % 2 * 2, workshopCamera());
  for (size_t i = 0; i < task.cameras.size(); ++i)
    task.cameras[i].toWorld[3].x += 0.1f * static_cast<float>(i) - 0.2f * static_cast<float>(thread);
  return task;
}

using Frames = std::vector<output::FrameOutput>;

// Renders all rounds of a thread; `meet` is called while each round's pictures are in flight.
template <typename Meet>
std::vector<Frames> renderRounds(vk::Device& device, const scene::Scene& scene, const scene::Environment& sky,
                                 uint32_t thread, Meet meet) {
  Renderer renderer(device, scene, &sky);
  std::vector<Frames> rounds;
  for (uint32_t round = 0; round < kRounds; ++round) {
    const Task task = taskOf(thread, round);
    Ticket ticket = renderer.submit(task.cameras, task.settings);
    meet();
    rounds.push_back(ticket.take().frames);
  }
  return rounds;
}

class ThreadsTest : public RenderTest {};

TEST_F(ThreadsTest, RenderersOfOneSceneDoNotDisturbEachOther) {
  const scene::Scene scene = workshop();
  const scene::Environment sky = constantEnvironment();
  std::vector<std::vector<Frames>> together(kThreads);
  std::vector<std::exception_ptr> errors(kThreads);
  {
    std::barrier barrier(kThreads);  // every round has pictures of all threads in flight at once
    std::vector<std::jthread> threads;
    for (uint32_t thread = 0; thread < kThreads; ++thread)
      threads.emplace_back([&, thread] {
        try {
          together[thread] = renderRounds(device(), scene, sky, thread, [&] { barrier.arrive_and_wait(); });
        } catch (...) {
          errors[thread] = std::current_exception();
          barrier.arrive_and_drop();
        }
      });
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  for (uint32_t thread = 0; thread < kThreads; ++thread) {
    const std::vector<Frames> alone = renderRounds(device(), scene, sky, thread, [] {});
    for (uint32_t round = 0; round < kRounds; ++round) {
      SCOPED_TRACE(fmt::format("thread {}, round {}", thread, round));
      ASSERT_EQ(together[thread][round].size(), alone[round].size());
      for (size_t view = 0; view < alone[round].size(); ++view)
        expectSame(together[thread][round][view], alone[round][view]);
    }
  }
  EXPECT_FALSE(together[0][0][0].display == together[1][0][0].display) << "the threads' pictures do differ";
}

}  // namespace
}  // namespace latelight::render::test
