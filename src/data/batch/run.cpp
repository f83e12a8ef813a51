#include "data/batch/run.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/threads.h"
#include "data/batch/parts_lock.h"
#include "data/batch/worker.h"
#include "data/stop.h"

namespace latelight::data {

namespace {

// Limits of one submission. They are large enough to fill a GPU and small enough that read-back memory is allocated
// quickly; on the CPU they are small enough that the program responds quickly to a signal.
constexpr AtOnce kOfGpu{256, 1 << 22}, kOfCpu{8, 1 << 19};

AtOnce atOnce(const Job& job, const BatchOptions& options) {
  bool cpu = false;
  for (const vk::DeviceInfo& device : vk::listDevices())
    cpu |= device.type == "cpu" && std::ranges::find(options.devices, device.uuid) != options.devices.end();
  AtOnce most = cpu ? kOfCpu : kOfGpu;
  // The three tickets of each worker and the data read back from one use at most a quarter of the memory.
  most.pixels = std::min(most.pixels, memoryLimit() / 4 / options.devices.size() / 6 / bytesOfPixel(job.settings));
  return most;
}

// Calls body(i) for each i below `count` on its own thread, or on as many threads as this process may start. After all
// threads have ended, throws the first exception of a thread, such as an error of a device that cannot be used.
void onThreads(size_t count, const std::function<void(size_t i)>& body) {
  std::exception_ptr first;
  std::mutex mutex;
  const auto run = [&](size_t i) {
    try {
      body(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!first) first = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  try {
    threads = startThreads(count, run);
  } catch (const std::system_error&) {
    fail(ExitCode::NoDevice, "this process may not start a thread that renders: raise `ulimit -u`");
  }
  for (std::thread& thread : threads) thread.join();
  if (first) std::rethrow_exception(first);
}

void render(const Job& job, Plan& plan, WorkList& work, ShardLog& log, const BatchOptions& options) {
  Progress progress("frames", work.frames());
  Writers writers(job, log, progress, options.writers, memoryLimit() / 8);
  SceneLoader loader(job, plan);
  // Devices are destroyed one after the other after all threads have ended, because NVIDIA's driver may hang in
  // vkDestroyDevice while another device executes work or is also being destroyed.
  std::vector<std::unique_ptr<Worker>> workers(options.devices.size());
  onThreads(workers.size(), [&](size_t i) {
    workers[i] =
        std::make_unique<Worker>(job, plan, loader, work, writers, log,
                                 vk::DeviceOptions{.selector = options.devices[i], .validation = options.validation});
    workers[i]->run();
  });
}

}  // namespace

namespace {

// A job whose cameras cannot be created leaves no folder, so that a corrected one needs no --resume.
Plan planOf(const Job& job, const SetFolder& set, const Shard& shard, bool isNew) {
  try {
    return Plan(job, set.plan());
  } catch (const Error&) {
    if (isNew) removeNewSet(set, shard);
    throw;
  }
}

}  // namespace

BatchResult runBatch(const Job& job, const BatchOptions& options) {
  const SetFolder set(job.folder);
  const bool isNew = openSet(set, job, options.shard, options.resume);
  const SetLock lock(set.shard(options.shard));
  const PartsLock parts(set.partsLock(), options.shard.count);
  stopOnSignals();
  Plan plan = planOf(job, set, options.shard, isNew);
  saveJob(set, job, plan);
  const auto [first, end] = options.shard.range(plan.frames());
  const Manifest found = findFinished(set, job, plan, options.shard);
  ShardLog log(set.shard(options.shard), found);
  for (const PlannedScene& scene : plan.scenes())
    if (!scene.error.empty()) log.failed(scene.source, scene.error);
  WorkList work(plan, first, end, found, atOnce(job, options));
  const std::string shard = "shard " + options.shard.name();
  if (!options.shardBy.empty()) set.log(fmt::format("{} is chosen by {}", shard, options.shardBy));
  set.log(fmt::format("{} begins: {} of {} frames are to be rendered", shard, work.frames(), end - first));
  std::exception_ptr error;
  try {
    if (work.frames() > 0) render(job, plan, work, log, options);
  } catch (const Stopped&) {  // reported by BatchResult::signal
  } catch (...) {
    error = std::current_exception();
  }
  log.end();
  set.log(fmt::format("{} ends: {} of {} frames are finished", shard, log.frames(), end - first));
  if (error) std::rethrow_exception(error);
  BatchResult result{end - first, log.frames(), log.whyFailed()};
  if (result.finished < result.frames) result.signal = stopSignal();
  try {
    mergeIfComplete(set);
  } catch (const Stopped& stopped) {
    result.signal = stopped.signal;
  }
  return result;
}

}  // namespace latelight::data
