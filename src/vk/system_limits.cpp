#include "vk/system_limits.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <vector>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/text.h"

namespace latelight::vk {

namespace {

// Opens as many files as the loader and a driver have open at once, and closes them.
bool mayOpenFiles() {
  std::array<int, 16> files{};
  bool full = false;
  for (int& file : files) {
    file = open("/", O_RDONLY | O_CLOEXEC);
    full = full || (file < 0 && (errno == EMFILE || errno == ENFILE));
  }
  for (const int file : files)
    if (file >= 0) close(file);
  return !full;
}

// The number of rasterizer threads of Mesa's llvmpipe, which has as many again for compute shaders.
size_t rasterizerThreads() {
  constexpr size_t kMax = 32;  // LP_MAX_THREADS
  cpu_set_t set;
  const size_t cores = sched_getaffinity(0, sizeof(set), &set) == 0 ? static_cast<size_t>(CPU_COUNT(&set)) : kMax;
  const char* text = std::getenv("LP_NUM_THREADS");
  const std::optional<size_t> chosen = text ? parseNumber<size_t>(text) : std::nullopt;
  return std::min(chosen.value_or(cores > 1 ? cores : 0), kMax);
}

// Threads that all exist at the same time until the object is destroyed.
class WaitingThreads {
 public:
  // Starts up to `count` threads. Their stacks are small, so that a limit on address space does not count.
  explicit WaitingThreads(size_t count) {
    constexpr size_t kStackBytes = size_t{256} << 10;
    threads_.reserve(count);  // running out of memory later would leave threads without their object
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kStackBytes);
    pthread_t thread{};
    while (threads_.size() < count && pthread_create(&thread, &attributes, wait, this) == 0) threads_.push_back(thread);
    pthread_attr_destroy(&attributes);
  }
  ~WaitingThreads() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    wake_.notify_all();
    for (const pthread_t thread : threads_) pthread_join(thread, nullptr);
  }
  WaitingThreads(const WaitingThreads&) = delete;
  WaitingThreads& operator=(const WaitingThreads&) = delete;
  size_t count() const { return threads_.size(); }

 private:
  static void* wait(void* object) {
    auto* self = static_cast<WaitingThreads*>(object);
    std::unique_lock lock(self->mutex_);
    self->wake_.wait(lock, [self] { return self->done_; });
    return nullptr;
  }

  std::vector<pthread_t> threads_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool done_ = false;
};

}  // namespace

std::optional<SystemLimit> limitOnDrivers() {
  constexpr uint64_t kDriver = uint64_t{512} << 20;
  if (const uint64_t left = addressesLeft(); left < kDriver)
    return SystemLimit{
        ExitCode::OutOfMemory,
        fmt::format("A Vulkan driver requires {} MiB of address space, but {} MiB are left", kDriver >> 20, left >> 20),
        "raise `ulimit -v`"};
  if (!mayOpenFiles())
    return SystemLimit{ExitCode::NoDevice, "A Vulkan driver requires more open files than this process may have",
                       "raise `ulimit -n`, or close files"};
  return std::nullopt;
}

std::optional<SystemLimit> limitOnCpuThreads() {
  constexpr size_t kOthers = 2;  // of the queue and of Mesa's shader cache
  // The threads of parallelFor() may start at the same time.
  const size_t required = 2 * rasterizerThreads() + kOthers + threadCount();
  const size_t started = WaitingThreads(required).count();
  if (started == required) return std::nullopt;
  return SystemLimit{
      ExitCode::NoDevice,
      fmt::format("The CPU device requires {} threads, but this process may start only {}", required, started),
      "raise `ulimit -u`, or the limit of the container on processes"};
}

}  // namespace latelight::vk
