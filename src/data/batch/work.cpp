#include "data/batch/work.h"

#include <algorithm>

namespace latelight::data {

WorkList::WorkList(const Plan& plan, uint64_t first, uint64_t end, const Manifest& finished, AtOnce most)
    : scenes_(plan.scenes().size()) {
  constexpr uint64_t kFrameBytes = 2 * sizeof(uint64_t) + sizeof(Chunk);  // each frame may need its own chunk
  memory_.grow((end - first) * kFrameBytes, "the list of the job's frames");
  for (uint64_t index = first; index < end; ++index) {
    const std::optional<FrameLocation> place = plan.at(index);
    if (!place || finished.frames.contains(index)) continue;
    const PlannedCamera& camera = plan.camera(*place);
    std::deque<Chunk>& chunks = scenes_[place->scene].chunks;
    const auto fits = [&](const Chunk& chunk) {
      return chunk.variation == place->variation && chunk.width == camera.width && chunk.height == camera.height &&
             plan.camera(*plan.at(chunk.frames.front())).moment == camera.moment && chunk.frames.size() < most.views &&
             (chunk.frames.size() + 1) * camera.width * camera.height <= most.pixels;
    };
    if (chunks.empty() || !fits(chunks.back()))
      chunks.push_back({place->scene, place->variation, camera.width, camera.height, {}});
    chunks.back().frames.push_back(index);
    ++frames_;
  }
}

std::optional<uint32_t> WorkList::claim(std::optional<uint32_t> except) {
  const std::lock_guard lock(mutex_);
  std::optional<uint32_t> best;
  for (uint32_t scene = 0; scene < scenes_.size(); ++scene)
    if (!scenes_[scene].chunks.empty() && scene != except && (!best || scenes_[scene].workers < scenes_[*best].workers))
      best = scene;
  if (best) ++scenes_[*best].workers;
  return best;
}

void WorkList::leave(uint32_t scene) {
  const std::lock_guard lock(mutex_);
  --scenes_[scene].workers;
}

std::optional<Chunk> WorkList::take(uint32_t scene) {
  const std::lock_guard lock(mutex_);
  std::deque<Chunk>& chunks = scenes_[scene].chunks;
  if (chunks.empty()) return std::nullopt;
  Chunk chunk = std::move(chunks.front());
  chunks.pop_front();
  return chunk;
}

std::vector<Chunk> WorkList::drop(uint32_t scene) {
  const std::lock_guard lock(mutex_);
  std::vector<Chunk> dropped(std::make_move_iterator(scenes_[scene].chunks.begin()),
                             std::make_move_iterator(scenes_[scene].chunks.end()));
  scenes_[scene].chunks.clear();
  return dropped;
}

}  // namespace latelight::data
