// A part of a job: which of its frames a process makes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace latelight::data {

struct Shard {
  uint32_t index = 0, count = 1;

  // Its frames, of that many: consecutive ones, so that few shards load one scene.
  std::pair<uint64_t, uint64_t> range(uint64_t frames) const;
  std::string name() const;  // "0-of-3"
};

struct ChosenShard {
  Shard shard;
  std::string by;  // the environment variables that chose it; empty: none
};

// "i/n", i from 0 to n - 1; also "/n" for a Kubernetes indexed job, whose environment has i alone. Empty: as the
// environment says (Slurm arrays and steps, Open MPI, PMI), or all. Throws Error(Usage).
ChosenShard chooseShard(const std::string& text,
                        const std::function<std::optional<std::string>(const char*)>& environment);

}  // namespace latelight::data
