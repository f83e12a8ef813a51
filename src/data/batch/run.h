// The run of a job, or of a shard of it, from its plan to its manifest.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "data/batch/job.h"
#include "data/batch/plan.h"
#include "data/batch/set.h"
#include "data/batch/shard.h"

namespace latelight::data {

struct BatchOptions {
  Shard shard;
  std::string shardBy;  // the environment variables that chose it; empty: none
  bool resume = false;
  std::vector<std::string> devices;  // a worker for each, by UUID
  size_t writers = 1;                // threads
  bool validation = false;
};

struct BatchResult {
  uint64_t frames = 0, finished = 0;          // of the shard
  std::map<std::string, std::string> failed;  // frames and scenes, and why
  int signal = 0;                             // that ended it before its end; 0: none
};

// Throws Error for what keeps all frames from being made, and Stopped where a signal ends it while cameras are still
// sought. The shard that completes the set merges it.
BatchResult runBatch(const Job& job, const BatchOptions& options);

}  // namespace latelight::data
