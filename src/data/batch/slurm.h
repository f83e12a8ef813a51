// Writes a Slurm job script that runs a batch as an array of shards, each requeued before its time limit.
#pragma once

#include <cstdint>
#include <string>

namespace latelight::data {

// Returns the script for sbatch. `command` is the shell command that renders the job, without --shard.
std::string slurmScript(const std::string& command, uint32_t shards);

// Quotes a text as one word of a shell command.
std::string quoted(const std::string& text);

}  // namespace latelight::data
