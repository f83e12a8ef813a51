// Per-cluster occlusion of the previous frame, in device memory, for two-pass occlusion culling: clusters that were not
// occluded are rasterized first, then the others are tested against the depth pyramid (HZB) of the first pass (Haar and
// Aaltonen 2015, GPU-Driven Rendering Pipelines, SIGGRAPH course). The bits are only a prediction and do not affect the
// image.
#pragma once

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "render/frame/frame.h"

namespace latelight::render {

// The separate histories: of views without jitter, of views with jitter, and of views whose blended surfaces count as
// opaque.
enum class OcclusionHistory { Steady, Jittered, WithBlended, Count };

class ClusterOcclusion {
 public:
  // Returns whether occlusion culling is expected to reduce the next frame's time; `clusters` is the number in all
  // views. If there are many, some frames always cull to measure, and the others do if enough clusters were occluded.
  bool shouldCull(const vk::Device& device, OcclusionHistory of, uint64_t clusters);
  // Returns the occlusion bits; `words` is the number of uint32_t for all views of the frame. Unknown bits are 0, which
  // means not occluded.
  graph::BufferId addTo(const FrameContext& f, OcclusionHistory of, uint64_t words);

  // The choices that determined the passes of frames. A recorded graph may be submitted again while the next frame
  // repeats() all of its choices; noteRepeated() counts that frame.
  struct Decision {
    OcclusionHistory of;
    uint64_t clusters;
    bool culls;
    std::shared_ptr<const vk::Buffer> buffer;  // the occlusion bits; null if it does not cull
    bool filled = false;
  };
  std::vector<Decision> takeDecisions() { return std::exchange(decisions_, {}); }  // since the last call
  bool repeats(const vk::Device& device, const Decision& decision) const;
  void noteRepeated(const Decision& decision) { ++kept_[static_cast<size_t>(decision.of)].frames; }

  // Counts of the last frame that culled: `found` clusters were rasterized although they had been occluded in the frame
  // before, `hidden` clusters are occluded.
  struct Counts {
    uint32_t found = 0, occluded = 0;
  };
  const Counts& counts(OcclusionHistory of) const { return kept_[static_cast<size_t>(of)].counts; }
  void keep(OcclusionHistory of, uint32_t found, uint32_t occluded) {
    kept_[static_cast<size_t>(of)].counts = {found, occluded};
  }

 private:
  struct Kept {
    std::shared_ptr<const vk::Buffer> buffer;  // kept alive by frames in flight
    bool filled = false;
    uint32_t frames = 0;  // frames so far; select those that measure
    Counts counts;
  };
  bool wouldCull(const vk::Device& device, OcclusionHistory of, uint64_t clusters) const;

  std::array<Kept, static_cast<size_t>(OcclusionHistory::Count)> kept_;
  std::vector<Decision> decisions_;
};

}  // namespace latelight::render
