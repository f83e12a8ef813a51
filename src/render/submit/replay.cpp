#include "render/submit/replay.h"

#include <algorithm>
#include <numeric>

namespace latelight::render {

namespace {

constexpr uint64_t kCallsKept = 4;      // calls after which an unused replay is dropped
constexpr size_t kMaxReplays = 64;      // of a renderer: each has a command buffer and its results' memory
constexpr size_t kMaxRemembered = 256;  // requests

}  // namespace

void ReplayCache::tick() {
  ++calls_;
  std::erase_if(entries_, [&](const Entry& entry) { return entry.lastCall + kCallsKept < calls_; });
}

ReplayCache::Entry* ReplayCache::entryOf(const ReplayKey& key) {
  const auto found = std::ranges::find(entries_, key, &Entry::key);
  return found == entries_.end() ? nullptr : &*found;
}

std::shared_ptr<Replay> ReplayCache::find(const ReplayKey& key, graph::Executor& executor,
                                          const ClusterOcclusion& occlusion, const vk::Device& device) {
  Entry* entry = entryOf(key);
  if (!entry) return nullptr;
  entry->lastCall = calls_;
  for (const std::shared_ptr<Replay>& replay : entry->replays) {
    if (replay.use_count() > 1 || !executor.isIdle(replay->recorded)) continue;
    const auto repeats = [&](const ClusterOcclusion::Decision& made) { return occlusion.repeats(device, made); };
    if (std::ranges::all_of(replay->decisions, repeats)) return replay;
  }
  return nullptr;
}

bool ReplayCache::shouldRecord(const ReplayKey& key) {
  if (!entryOf(key)) {
    if (entries_.size() < kMaxRemembered) entries_.push_back({key, calls_, {}});
    return false;
  }
  const size_t replays = std::accumulate(entries_.begin(), entries_.end(), size_t{0},
                                         [](size_t sum, const Entry& entry) { return sum + entry.replays.size(); });
  return replays < kMaxReplays;
}

void ReplayCache::forget(const ReplayKey& key) {
  std::erase_if(entries_, [&](const Entry& entry) { return entry.key == key; });
}

void ReplayCache::add(const ReplayKey& key, std::shared_ptr<Replay> replay) {
  if (Entry* entry = entryOf(key)) entry->replays.push_back(std::move(replay));
}

}  // namespace latelight::render
