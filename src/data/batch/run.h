// Runs a job, or one shard of it, from the plan to the manifest.
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
  std::string shardBy;  // the environment variables that chose the shard; empty: none
  bool resume = false;
  std::vector<std::string> devices;  // UUIDs; each device has one worker
  size_t writers = 1;                // number of threads
  bool validation = false;
};

struct BatchResult {
  uint64_t frames = 0, finished = 0;          // numbers of frames in the shard
  std::map<std::string, std::string> failed;  // reasons by name of the frame or scene
  int signal = 0;                             // the signal that stopped the run or its merge early; 0: none
};

// Renders the missing frames of a shard. The shard that completes the set also merges it. Throws Error for problems
// that prevent all frames from being rendered, and Stopped if a signal arrives while the plan is still searching for
// cameras.
BatchResult runBatch(const Job& job, const BatchOptions& options);

}  // namespace latelight::data
