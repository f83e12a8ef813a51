#include "render/submit/replay.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "base/error.h"
#include "render/frame/view.h"
#include "render/lighting/technique.h"
#include "render/submit/job.h"
#include "render/submit/renderer.h"

namespace latelight::render {

namespace {

constexpr size_t kCallsKept = 4;        // different calls
constexpr uint64_t kMaxAge = 256;       // calls after which an unused replay is dropped
constexpr size_t kMaxReplays = 64;      // of a renderer: each has a command buffer and its results' memory
constexpr size_t kMaxRemembered = 256;  // requests

}  // namespace

// An agent's loop alternates between a few calls, some of which are rare, such as those of an evaluation.
void ReplayCache::tick() {
  ++calls_;
  std::set<uint64_t, std::greater<>> last{calls_};
  for (const Entry& entry : entries_) last.insert(entry.lastCall);
  const auto oldest = last.size() > kCallsKept ? *std::next(last.begin(), kCallsKept) : uint64_t{0};
  std::erase_if(entries_,
                [&](const Entry& entry) { return entry.lastCall < oldest || entry.lastCall + kMaxAge < calls_; });
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

std::optional<ReplayKey> Renderer::replayKey(const ViewBatch& part) const {
  const Settings& s = part.job.settings;
  if (!sceneInput_ || !rastersInCompute(s) || s.lighting->draws || s.aa.superSampling > 1 || keepsHistory(s) ||
      s.describeGraph || (part.shadows && !part.shadows->tracesRays()) || part.job.exposes || part.job.rowsAreViews ||
      bendsRays(part.job.camera(part.first)))
    return std::nullopt;
  ReplayKey key{
      .views = part.count,
      .firstView = part.job.result.arrays.empty() ? 0 : part.first,
      .arrays = {},
      .strip = part.strip,
      .results = part.job.results,
      .revisions = {sceneInput_->edits[0], sceneInput_->edits[1], sceneInput_->edits[2],
                    gpuScene_.materials().sceneRevision(), gpuScene_.materials().textureRevision()},
      .textureSlots = gpuScene_.materials().textureSlots(),
      .codedTextureSlots = gpuScene_.materials().codedTextureSlots(),
      .traits = gpuScene_.traits(),
      .layers = gpuScene_.materials().layers(),
      .worlds = part.job.placedWorlds > 0 ? ReplayKey::Worlds::PlacedByShaders
                : gpuScene_.hasWorlds()   ? ReplayKey::Worlds::ConvertedByHost
                                          : ReplayKey::Worlds::None,
      .metered = !part.job.meteredExposures.empty(),
      .mixesBlended = rasterInstances_.mixesBlended(),
      .anyBlended = rasterInstances_.anyBlended(),
      .lights = gpuScene_.lightCount(),
      .localLights = gpuScene_.localLights(),
      .unboundedLights = gpuScene_.unboundedLights(),
      .areaLights = gpuScene_.areaLights(),
      .anyVast = gpuScene_.anyVast(),
      .textures = device_.maxTextureArray() ? gpuScene_.materials().textureSet() : VK_NULL_HANDLE,
      .environment = state_.environment,
      .placedShadows = {},
      .shadowColumns = part.shadows ? part.shadows->columns() : 0,
      .shadowRays = part.shadows && device_.isCpu() ? part.shadows->mostRays() : 0,
      .emitters = bvh_ && tracesPaths(s) ? bvh_->emitterCount() : 0,
      .anyTranslucent = tracesPaths(s) && gpuScene_.anyTranslucent(),
      .groundHeight = s.ground == Ground::None ? 0 : s.groundHeight.value_or(lowestPoint_) - gpuScene_.origin().z,
      .loadsTexels = device_.memory().isAllInWindow(),
      .instances = rasterInstances_.address(),
      .firstTriangles = rasterInstances_.firstTriangles(),
      .objectFrames = gpuScene_.objectFrames(),
      .solid = rasterInstances_.solid(),
      .all = rasterInstances_.all(),
      .materials = rasterInstances_.materials(),
      .ambientOcclusionScale =
          s.ambientOcclusion == AmbientOcclusion::None || gpuScene_.hasWorlds() ? 0 : gpuScene_.bounds().radius(),
      .capacities = {overflow_.fragments, overflow_.longestList, overflow_.rasterWork, overflow_.clippedTriangles,
                     overflow_.mediumTriangles, overflow_.largeTriangles, overflow_.tileEntries},
      .settings = s,
  };
  if (state_.placesShadows())
    key.placedShadows = {placedShadows_.suns.size(), placedShadows_.locals.size(), placedShadows_.localMaps,
                         placedShadows_.depths.size(), placedShadows_.lights.size()};
  for (const ExportedArray& array : part.job.result.arrays) key.arrays.push_back(array.memory->serial);
  return key;
}

std::shared_ptr<Replay> Renderer::replayOf(ViewBatch& part, const ReplayKey& key) {
  if (std::shared_ptr<Replay> replay = replays_.find(key, executor_, clusterOcclusion_, device_)) {
    replay->update(part.job.placedWorlds > 0 ? placedViewsOf(part) : viewsOf(part, CameraSample{}), part.shadows);
    for (const ClusterOcclusion::Decision& decision : replay->decisions) clusterOcclusion_.noteRepeated(decision);
    part.replayed = true;
    return replay;
  }
  if (!replays_.shouldRecord(key)) return nullptr;
  try {
    std::shared_ptr<Replay> replay = recordReplay(part);
    replays_.add(key, replay);
    return replay;
  } catch (const Error& error) {
    if (error.code() != ExitCode::OutOfMemory) throw;
  }
  replays_.clear();
  return nullptr;
}

std::shared_ptr<Replay> Renderer::recordReplay(const ViewBatch& part) {
  const Settings& s = part.job.settings;
  const ViewsInTime views = viewsOf(part, CameraSample{});
  const ResultArrays arrays{part.job.result.arrays, part.first, part.strip.first};
  overflow_.checks.clear();  // left by an error
  clusterOcclusion_.takeDecisions();
  const auto replay =
      std::make_shared<Replay>(s, state_, scene_.yUp && s.axes == Axes::File, views, part.shadows, arrays);
  replay->request.finish({}, {});
  replay->request.exportResults(part.job.results);
  replay->request.addConstants();
  replay->checks = std::exchange(overflow_.checks, {});
  replay->decisions = clusterOcclusion_.takeDecisions();
  replay->recorded = executor_.record(replay->request.graph(), replay->request.graph().compile());
  return replay;
}

// Submits the scene's changes in a graph of their own, before the commands of a replay.
void Renderer::submitChanges(ViewBatch& part) {
  graph::Graph graph(executor_);
  addSceneChanges(graph);
  if (graph.passCount() > 0) part.earlier.push_back(submit(graph, graph.compile()));
}

}  // namespace latelight::render
