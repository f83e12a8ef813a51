// Replays: a request that differs from an earlier one only in data (cameras, transforms, lights) submits the commands
// of that request again. Its graph, memory, descriptor sets and command buffer are kept, and the host only writes the
// views and the frame's constants to the buffers that the commands read.
//
// This requires the raster compute, whose commands do not depend on the views: the device culls. The graphics pipeline
// draws lists of instances that the host has culled per view, so its requests are recorded each time.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "render/submit/request.h"
#include "render/submit/strips.h"

namespace latelight::render {

// Everything except data that the commands of some views depend on.
struct ReplayKey {
  size_t views, firstView;       // firstView: in the exported arrays
  std::vector<uint64_t> arrays;  // ExportedMemory::serial
  Strip strip;
  Results results;
  // The scene on the device.
  // Numbers of the scene's meshes, materials and textures as edited, of materials as posed, and of the sets that bind
  // their textures.
  std::array<uint64_t, 5> revisions;
  uint32_t textureSlots, codedTextureSlots, traits, layers;  // of materials, including those of worlds
  enum class Worlds : uint8_t { None, ConvertedByHost, PlacedByShaders } worlds;
  bool metered;  // views have exposures of their own
  bool mixesBlended, anyBlended;
  uint32_t lights, localLights, unboundedLights, areaLights;
  bool anyVast;
  VkDescriptorSet textures;
  const GpuEnvironment* environment;
  // If shaders fit shadow maps: numbers of directional and local lights, of the maps of the latter, of views per world,
  // and of words with a bit per light.
  std::array<size_t, 5> placedShadows;
  // For ray-traced light: the number of lights with shadows, the maximum number of shadow rays per surface,
  // RayScene::emitterCount, GpuScene::anyTranslucent(), and the height of the ground.
  uint32_t shadowColumns, shadowRays, emitters;
  bool anyTranslucent;
  double groundHeight;
  bool loadsTexels;  // of pipelines (vk/texel_window.h)
  VkDeviceAddress instances, firstTriangles;
  VkDeviceAddress objectFrames;
  RasterInstances::Share solid, all;
  VisibleMaterials materials;
  double ambientOcclusionScale;        // the scene's radius; 0 without ambient occlusion
  std::array<uint64_t, 7> capacities;  // of Overflow
  Settings settings;
  bool operator==(const ReplayKey&) const = default;
};

// A request, recorded. Whoever holds it may read the results of its last submission.
struct Replay {
  // `shadows`: those of rays, or null.
  Replay(const Settings& settings, const RenderState& state, bool yUp, const ViewsInTime& views,
         std::shared_ptr<FrameShadows> shadows, const ResultArrays& arrays)
      : settings(settings),
        shadows(std::move(shadows)),
        request(state, this->settings, yUp, views, views, this->shadows.get(), {}, arrays) {}
  // Replaces the views and the shadows by those of another call with the same key. Nothing in flight may use them.
  void update(const ViewsInTime& views, std::shared_ptr<FrameShadows> newShadows) {
    request.update(views, newShadows.get());
    shadows = std::move(newShadows);
  }

  const Settings settings;
  std::shared_ptr<FrameShadows> shadows;
  FrameGraphBuilder request;
  std::vector<Overflow::Check> checks;
  std::vector<ClusterOcclusion::Decision> decisions;
  std::shared_ptr<graph::RecordedGraph> recorded;
};

class ReplayCache {
 public:
  // Call it once per call of the renderer. Drops replays that the last few different calls did not use.
  void tick();
  void clear() { entries_.clear(); }
  bool empty() const { return entries_.empty(); }

  // Returns a replay that no submission in flight and no results use, or null.
  std::shared_ptr<Replay> find(const ReplayKey& key, graph::Executor& executor, const ClusterOcclusion& occlusion,
                               const vk::Device& device);
  // Returns true if a request should be recorded for replay, because an equal one came before. Most requests come once.
  bool shouldRecord(const ReplayKey& key);
  void add(const ReplayKey& key, std::shared_ptr<Replay> replay);
  void forget(const ReplayKey& key);  // a request that did not fit into memory

 private:
  struct Entry {
    ReplayKey key;
    uint64_t lastCall;
    std::vector<std::shared_ptr<Replay>> replays;
  };
  Entry* entryOf(const ReplayKey& key);

  std::vector<Entry> entries_;
  uint64_t calls_ = 0;
};

}  // namespace latelight::render
