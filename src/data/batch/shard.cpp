#include "data/batch/shard.h"

#include <algorithm>

#include "base/error.h"
#include "base/text.h"

namespace latelight::data {

namespace {

using Environment = std::function<std::optional<std::string>(const char*)>;

constexpr uint32_t kMostShards = 1'000'000;

std::optional<uint32_t> numberIn(const Environment& environment, const char* name) {
  const std::optional<std::string> text = environment(name);
  if (!text) return std::nullopt;
  const std::optional<uint32_t> value = parseNumber<uint32_t>(*text);
  if (!value) badUsage("the environment variable {} must be a whole number, not \"{}\"; use --shard i/n", name, *text);
  return value;
}

Shard checked(uint64_t index, uint64_t count, std::string_view from) {
  if (count == 0 || count > kMostShards || index >= count)
    badUsage("{} takes i/n with i from 0 to n - 1, not {}/{}", from, index, count);
  return {static_cast<uint32_t>(index), static_cast<uint32_t>(count)};
}

std::optional<Shard> from(const Environment& environment, const char* index, const char* count) {
  const std::optional<uint32_t> i = numberIn(environment, index), n = numberIn(environment, count);
  if (!i || !n) return std::nullopt;
  return checked(*i, *n, fmt::format("--shard, here by {} and {},", index, count));
}

// An array of jobs, each perhaps of several tasks.
std::optional<Shard> fromSlurm(const Environment& environment) {
  const std::optional<Shard> task = from(environment, "SLURM_PROCID", "SLURM_NTASKS");
  const auto id = numberIn(environment, "SLURM_ARRAY_TASK_ID"), first = numberIn(environment, "SLURM_ARRAY_TASK_MIN"),
             count = numberIn(environment, "SLURM_ARRAY_TASK_COUNT"),
             last = numberIn(environment, "SLURM_ARRAY_TASK_MAX");
  if (!id || !first || !count) return task;
  if (last && *last - *first + 1 != *count)
    badUsage("the Slurm array {}-{} has {} jobs, and shards are counted without gaps: give --shard i/n", *first, *last,
             *count);
  const Shard inner = task.value_or(Shard{});
  return checked(uint64_t{*id - *first} * inner.count + inner.index, uint64_t{*count} * inner.count,
                 "--shard, here by SLURM_ARRAY_TASK_ID,");
}

}  // namespace

std::pair<uint64_t, uint64_t> Shard::range(uint64_t frames) const {
  return {frames * index / count, frames * (index + 1) / count};
}

std::string Shard::name() const {
  return fmt::format("{}-of-{}", index, count);
}

Shard chooseShard(const std::string& text, const Environment& environment) {
  if (text.empty()) {
    if (const auto shard = fromSlurm(environment)) return *shard;
    if (const auto shard = from(environment, "OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE")) return *shard;
    return from(environment, "PMI_RANK", "PMI_SIZE").value_or(Shard{});
  }
  const size_t slash = std::min(text.find('/'), text.size());
  const std::string_view all = text;
  const auto count = parseNumber<uint32_t>(slash == text.size() ? "" : all.substr(slash + 1));
  const auto index =
      slash == 0 ? numberIn(environment, "JOB_COMPLETION_INDEX") : parseNumber<uint32_t>(all.substr(0, slash));
  if (!index || !count)
    badUsage("--shard takes i/n, as in 0/8, or /n where JOB_COMPLETION_INDEX says which, not \"{}\"", text);
  return checked(*index, *count, "--shard");
}

}  // namespace latelight::data
