#include "data/batch/shard.h"

#include <algorithm>

#include "base/error.h"
#include "base/text.h"

namespace latelight::data {

namespace {

using Environment = std::function<std::optional<std::string>(const char*)>;

constexpr uint32_t kMaxShards = 1'000'000;

std::optional<uint32_t> numberIn(const Environment& environment, const char* name) {
  const std::optional<std::string> text = environment(name);
  if (!text) return std::nullopt;
  const std::optional<uint32_t> value = parseNumber<uint32_t>(*text);
  if (!value) badUsage("the environment variable {} must be a whole number, not \"{}\"; use --shard i/n", name, *text);
  return value;
}

Shard checked(uint64_t index, uint64_t count, std::string_view from) {
  if (count == 0 || count > kMaxShards || index >= count)
    badUsage("{} takes i/n with i from 0 to n - 1, not {}/{}", from, index, count);
  return {static_cast<uint32_t>(index), static_cast<uint32_t>(count)};
}

std::optional<SelectedShard> from(const Environment& environment, const char* index, const char* count) {
  const std::optional<uint32_t> i = numberIn(environment, index), n = numberIn(environment, count);
  if (!i || !n) return std::nullopt;
  const std::string by = fmt::format("{} and {}", index, count);
  return SelectedShard{checked(*i, *n, fmt::format("--shard, here by {},", by)), by};
}

// A shard per task of a Slurm step, which srun starts. Outside of a step there is only one process, a batch script or
// an interactive shell, although Slurm sets the rank and the number of tasks there, too.
std::optional<SelectedShard> fromSlurmStep(const Environment& environment) {
  constexpr uint32_t kFirstSpecialStep = 0xfffffff0;  // batch scripts, interactive steps and similar
  const std::optional<uint32_t> step = numberIn(environment, "SLURM_STEP_ID");
  if (!step || *step >= kFirstSpecialStep) return std::nullopt;
  if (environment("SLURM_STEP_NUM_TASKS")) return from(environment, "SLURM_PROCID", "SLURM_STEP_NUM_TASKS");
  return from(environment, "SLURM_PROCID", "SLURM_NTASKS");
}

// A shard per process that a launcher started. mpirun's own variables have priority, because mpirun starts through a
// Slurm step whose tasks are its daemons.
std::optional<SelectedShard> fromLauncher(const Environment& environment) {
  if (auto part = from(environment, "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE")) return part;
  if (auto part = from(environment, "PMI_RANK", "PMI_SIZE")) return part;
  return fromSlurmStep(environment);
}

std::optional<SelectedShard> fromArray(const Environment& environment) {
  const auto id = numberIn(environment, "SLURM_ARRAY_TASK_ID"), first = numberIn(environment, "SLURM_ARRAY_TASK_MIN"),
             count = numberIn(environment, "SLURM_ARRAY_TASK_COUNT"),
             last = numberIn(environment, "SLURM_ARRAY_TASK_MAX");
  if (!id || !first || !count) return std::nullopt;
  if (last && *last - *first + 1 != *count)
    badUsage("the Slurm array {}-{} has {} jobs, and shards are counted without gaps: give --shard i/n", *first, *last,
             *count);
  return SelectedShard{checked(uint64_t{*id} - *first, *count, "--shard, here by SLURM_ARRAY_TASK_ID,"),
                       "SLURM_ARRAY_TASK_ID, _MIN and _COUNT"};
}

// Combines the job array with the launcher: each job of the array may consist of several processes.
SelectedShard fromEnvironment(const Environment& environment) {
  const std::optional<SelectedShard> array = fromArray(environment), inner = fromLauncher(environment);
  if (!array || !inner) return array.value_or(inner.value_or(SelectedShard{}));
  const Shard &outer = array->shard, &own = inner->shard;
  const std::string by = array->by + " with " + inner->by;
  return {checked(uint64_t{outer.index} * own.count + own.index, uint64_t{outer.count} * own.count,
                  fmt::format("--shard, here by {},", by)),
          by};
}

}  // namespace

std::pair<uint64_t, uint64_t> Shard::range(uint64_t frames) const {
  return {frames * index / count, frames * (index + 1) / count};
}

std::string Shard::name() const {
  return fmt::format("{}-of-{}", index, count);
}

SelectedShard chooseShard(const std::string& text, const Environment& environment) {
  if (text.empty()) return fromEnvironment(environment);
  const size_t slash = std::min(text.find('/'), text.size());
  const std::string_view all = text;
  const bool isIndexed = slash == 0;
  const auto count = parseNumber<uint32_t>(slash == text.size() ? "" : all.substr(slash + 1));
  const auto index =
      isIndexed ? numberIn(environment, "JOB_COMPLETION_INDEX") : parseNumber<uint32_t>(all.substr(0, slash));
  if (!index || !count)
    badUsage("--shard takes i/n, as in 0/8, or /n where JOB_COMPLETION_INDEX says which, not \"{}\"", text);
  return {checked(*index, *count, "--shard"), isIndexed ? "JOB_COMPLETION_INDEX" : ""};
}

}  // namespace latelight::data
