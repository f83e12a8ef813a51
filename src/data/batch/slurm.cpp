#include "data/batch/slurm.h"

#include <fmt/format.h>

namespace latelight::data {

namespace {

// On SIGTERM the batch writes the frames in flight and ends with exit code 6. Slurm sends the signal 120 seconds before
// the time limit.
constexpr const char* kScript = R"(#!/bin/bash
#SBATCH --job-name=latelight
#SBATCH --array=0-{}
#SBATCH --ntasks=1
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@120
# Add what the cluster needs: --partition, --time, --gres=gpu:1, --cpus-per-task, ...
# What follows the name of this script, where it is submitted, is passed on to the batch.

stopped=
trap 'stopped=yes; kill -TERM "$batch"' TERM
{} --resume "$@" &
batch=$!
wait "$batch"; code=$?
while kill -0 "$batch" 2>/dev/null; do wait "$batch"; code=$?; done
if [[ $stopped && $code == 6 ]]; then
  exec scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}"
fi
exit "$code"
)";

}  // namespace

std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string slurmScript(const std::string& command, uint32_t shards) {
  return fmt::format(fmt::runtime(kScript), shards - 1, command);
}

}  // namespace latelight::data
