// A shard, the range of a job's frames that one process renders.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace latelight::data {

struct Shard {
  uint32_t index = 0, count = 1;

  // Returns the shard's range [first, end) of the job's `frames`. Frames are consecutive, so that few shards load the
  // same scene.
  std::pair<uint64_t, uint64_t> range(uint64_t frames) const;
  std::string name() const;  // "0-of-3"
};

struct SelectedShard {
  Shard shard;
  std::string by;  // the environment variables that chose the shard; empty: none
};

// Chooses a shard by the text of --shard: "i/n", with i from 0 to n - 1, or "/n" in a Kubernetes indexed job, whose
// environment sets only i. If the text is empty, the environment (Slurm arrays and steps, Open MPI, PMI) chooses the
// shard; if it does not, the shard is the whole job. Throws Error(Usage).
SelectedShard chooseShard(const std::string& text,
                          const std::function<std::optional<std::string>(const char*)>& environment);

}  // namespace latelight::data
