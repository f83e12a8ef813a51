// Threads that write rendered frames in all formats and record them in the shard log.
#pragma once

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "base/log.h"
#include "data/batch/job.h"
#include "data/batch/shard_log.h"
#include "data/frame.h"

namespace latelight::data {

struct RenderedFrame {
  DataFrame frame;
  FinishedFrame record;  // without files and entries
};

class Writers {
 public:
  // The queue holds at most `waiting` bytes of pictures and a few frames per thread.
  Writers(const Job& job, ShardLog& log, Progress& progress, size_t threads, uint64_t waiting);
  ~Writers();  // waits until all frames are written
  Writers(const Writers&) = delete;
  Writers& operator=(const Writers&) = delete;

  void push(RenderedFrame frame);  // waits for free capacity in the queue

 private:
  void work();
  void write(RenderedFrame frame);

  const Job& job_;
  ShardLog& log_;
  Progress& progress_;
  uint64_t most_, bytes_ = 0;
  bool done_ = false;
  std::mutex mutex_;
  std::condition_variable more_, spaceFreed_;
  std::deque<RenderedFrame> waiting_;
  std::vector<std::thread> threads_;
};

}  // namespace latelight::data
