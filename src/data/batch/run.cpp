#include "data/batch/run.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "data/batch/stop.h"
#include "data/batch/worker.h"

namespace latelight::data {

namespace {

// Enough to fill a GPU; on the CPU, few enough that a signal is followed soon.
constexpr AtOnce kOfGpu{256, 1 << 24}, kOfCpu{8, 1 << 19};

AtOnce atOnce(const Job& job, const BatchOptions& options) {
  bool cpu = false;
  for (const vk::DeviceInfo& device : vk::listDevices())
    cpu |= device.type == "cpu" && std::ranges::find(options.devices, device.uuid) != options.devices.end();
  AtOnce most = cpu ? kOfCpu : kOfGpu;
  // Three tickets a worker and what is read back of one take a quarter of the memory.
  most.pixels = std::min(most.pixels, memoryLimit() / 4 / options.devices.size() / 6 / bytesOfPixel(job.settings));
  return most;
}

// A worker a device, each on a thread of its own; the first error of one, such as a device that can't be used, is
// thrown once all have ended.
void runWorkers(const BatchOptions& options, const std::function<void(const std::string& device)>& body) {
  std::exception_ptr first;
  std::mutex mutex;
  std::vector<std::thread> threads;
  for (const std::string& device : options.devices)
    threads.emplace_back([&] {
      try {
        body(device);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!first) first = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  if (first) std::rethrow_exception(first);
}

void render(const Job& job, Plan& plan, WorkList& work, ShardLog& log, const BatchOptions& options) {
  Progress progress("frames", work.frames());
  Writers writers(job, log, progress, options.writers, memoryLimit() / 8);
  SceneLoader loader(job, plan);
  runWorkers(options, [&](const std::string& device) {
    Worker(job, plan, loader, work, writers, log, {.selector = device, .validation = options.validation}).run();
  });
}

}  // namespace

BatchResult runBatch(const Job& job, const BatchOptions& options) {
  const SetFolder set(job.folder);
  openSet(set, job, options.shard, options.resume);
  const SetLock lock(set.shard(options.shard));
  Plan plan(job, set.plan());
  plan.save(set.plan());
  const auto [first, end] = options.shard.range(plan.frames());
  const Manifest found = findFinished(set, plan, options.shard);
  ShardLog log(set.shard(options.shard), found);
  for (const PlannedScene& scene : plan.scenes())
    if (!scene.error.empty()) log.failed(scene.source, scene.error);
  WorkList work(plan, first, end, found, atOnce(job, options));
  const std::string shard = "shard " + options.shard.name();
  set.log(fmt::format("{} begins: {} of {} frames are to be rendered", shard, work.frames(), end - first));
  stopOnSignals();
  std::exception_ptr error;
  try {
    if (work.frames() > 0) render(job, plan, work, log, options);
  } catch (...) {
    error = std::current_exception();
  }
  log.end();
  set.log(fmt::format("{} ends: {} of {} frames are finished", shard, log.frames(), end - first));
  if (error) std::rethrow_exception(error);
  mergeIfComplete(set);
  return {end - first, log.frames(), log.whyFailed(), log.frames() < end - first ? stopSignal() : 0};
}

}  // namespace latelight::data
