#include "base/parallel.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "base/fork.h"
#include "base/log.h"
#include "base/text.h"
#include "base/threads.h"

namespace latelight {
namespace {

constexpr size_t kMaxThreads = 1024;

std::optional<size_t> requestedThreads() {
  const char* text = std::getenv("LATELIGHT_THREADS");
  if (!text || !*text) return std::nullopt;
  if (const auto count = parseNumber<size_t>(text); count && *count >= 1 && *count <= kMaxThreads) return count;
  warn("LATELIGHT_THREADS is '{}', which is not a number of threads, and is ignored: use a number from 1 to {}", text,
       kMaxThreads);
  return std::nullopt;
}

// The cores that this process may use. Batch systems and containers restrict them.
size_t coresLent() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof(set), &set) == 0) return static_cast<size_t>(std::max(1, CPU_COUNT(&set)));
  return std::max(1u, std::thread::hardware_concurrency());  // the machine has more cores than cpu_set_t has bits
}

// One call of parallelFor. Chunks are distributed in order, so when a chunk throws, all earlier chunks were
// distributed, too. Storing the exception of the first chunk therefore makes the rethrown exception the same on every
// run.
struct ParallelLoop {
  ParallelLoop(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body)
      : count(count), grain(grain), chunks((count + grain - 1) / grain), body(body) {}

  const size_t count, grain, chunks;
  const std::function<void(size_t, size_t)>& body;  // valid while the caller waits: until `running` is 0
  std::atomic<size_t> next = 0;

  std::mutex mutex;
  std::condition_variable finished;
  size_t running = 0;  // threads in work(), excluding the caller's
  size_t failedChunk = ~size_t{0};
  std::exception_ptr failure;

  bool exhausted() const { return next >= chunks; }

  void work() {
    for (size_t chunk = next++; chunk < chunks; chunk = next++) {
      try {
        body(chunk * grain, std::min(count, (chunk + 1) * grain));
      } catch (...) {
        std::lock_guard lock(mutex);
        if (chunk < failedChunk) {
          failedChunk = chunk;
          failure = std::current_exception();
        }
        next = chunks;
      }
    }
  }
};

class Pool {
 public:
  explicit Pool(size_t workers) {
    try {
      for (std::thread& thread : startThreads(workers, [this](size_t) { serve(); })) thread.detach();
    } catch (const std::exception&) {
      // Threads or memory are limited. No thread has started, and the caller does the work.
    }
  }

  void run(const std::shared_ptr<ParallelLoop>& loop) {
    {
      std::lock_guard lock(mutex_);
      loops_.push_back(loop);
    }
    // Wakes only as many threads as there is work for: the caller participates, and idle threads would only contend for
    // the lock.
    for (size_t i = 1; i < std::min(loop->chunks, threadCount()); ++i) wake_.notify_one();
    loop->work();
    {
      std::lock_guard lock(mutex_);
      std::erase(loops_, loop);
    }
    // The caller waits only for running chunks, so nesting cannot deadlock.
    std::unique_lock lock(loop->mutex);
    loop->finished.wait(lock, [&] { return loop->running == 0; });
  }

 private:
  // Returns the newest loop with remaining work, so inner loops finish before outer ones. It joins the loop under the
  // pool's lock: after run() has removed the loop from the list, no thread joins later.
  std::shared_ptr<ParallelLoop> join() {
    std::unique_lock lock(mutex_);
    std::shared_ptr<ParallelLoop> loop;
    wake_.wait(lock, [&] {
      const auto found = std::find_if(loops_.rbegin(), loops_.rend(), [](const auto& j) { return !j->exhausted(); });
      if (found == loops_.rend()) return false;
      loop = *found;
      return true;
    });
    std::lock_guard joined(loop->mutex);
    ++loop->running;
    return loop;
  }

  void serve() {
    for (;;) {
      const std::shared_ptr<ParallelLoop> loop = join();
      loop->work();
      std::lock_guard lock(loop->mutex);
      if (--loop->running == 0) loop->finished.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::shared_ptr<ParallelLoop>> loops_;
};

thread_local bool serialScope = false;

// The pool is never destroyed, because its threads wait on it until the process ends. A forked process has none of
// those threads, and creates its own pool.
Pool& pool() {
  struct Instance {
    uint32_t generation = forkGeneration();
    Pool pool{threadCount() - 1};
  };
  static ForkSafeMutex making;
  static std::atomic<Instance*> current = nullptr;
  const auto isUsable = [](const Instance* instance) { return instance && instance->generation == forkGeneration(); };
  Instance* instance = current;
  if (isUsable(instance)) return instance->pool;
  const std::lock_guard lock(making);
  if (!isUsable(current)) current = new Instance;
  return current.load()->pool;
}

}  // namespace

size_t threadCount() {
  static const size_t count = [] {
    const std::optional<size_t> asked = requestedThreads();
    return asked ? *asked : std::min(coresLent(), kMaxThreads);
  }();
  return count;
}

SerialScope::SerialScope() : before_(std::exchange(serialScope, true)) {}

SerialScope::~SerialScope() {
  serialScope = before_;
}

void parallelFor(size_t count, size_t grain, const std::function<void(size_t begin, size_t end)>& body) {
  if (count == 0) return;
  const auto loop = std::make_shared<ParallelLoop>(count, std::max<size_t>(grain, 1), body);
  if (loop->chunks == 1 || threadCount() == 1 || serialScope) {
    loop->work();
  } else {
    pool().run(loop);
  }
  if (loop->failure) std::rethrow_exception(loop->failure);
}

void copyInParallel(std::span<const MemoryCopy> copies) {
  constexpr size_t kPiece = size_t{256} << 10;  // small enough to occupy all threads, and worth waking one
  std::vector<MemoryCopy> pieces;
  for (const MemoryCopy& copy : copies)
    for (size_t at = 0; at < copy.bytes; at += kPiece)
      pieces.push_back({copy.to + at, copy.from + at, std::min(kPiece, copy.bytes - at)});
  parallelFor(pieces.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) std::memcpy(pieces[i].to, pieces[i].from, pieces[i].bytes);
  });
}

}  // namespace latelight
