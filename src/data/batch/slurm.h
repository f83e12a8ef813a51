// A job of Slurm's that runs a batch: an array of shards, each requeued before its time is over.
#pragma once

#include <cstdint>
#include <string>

namespace latelight::data {

// The script for sbatch. `command` is the shell's text that renders the job, but for its shard.
std::string slurmScript(const std::string& command, uint32_t shards);

// A text as one word of the shell's.
std::string quoted(const std::string& text);

}  // namespace latelight::data
