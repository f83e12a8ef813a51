// The order in which hardware draws a scene, and what of it a view may see.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "render/frame/frustum.h"
#include "render/gpu_scene/gpu_scene.h"

namespace latelight::render {

// Instances of one mesh, one material and one winding: one instanced draw.
struct Draw {
  uint32_t mesh = 0, material = 0;
  bool clockwise = false;
  bool vast = false;              // its triangles are drawn as fans (kVastFan)
  uint32_t first = 0, count = 0;  // among DrawList::instances
};

// What is drawn, in order.
struct DrawList {
  std::vector<Draw> draws;
  std::vector<uint32_t> instances;  // as the scene numbers them
  bool empty() const { return draws.empty(); }
};

// Instances by material, then mesh, then their number: few changes of material, and many instances a draw.
class DrawOrder {
 public:
  // Follows the scene's instances; costs nothing where none has changed.
  void update(const GpuScene& scene);

  enum class Kind { Solid, Blended };  // opaque and masked; alpha-blended
  bool anyBlended() const { return anyBlended_; }
  // Those of a kind whose bounds are wanted, which is asked on all threads. `group`: only those of it; 0: all.
  DrawList select(const GpuScene& scene, Kind kind, const std::function<bool(const Sphere&)>& wanted,
                  uint32_t group = 0) const;

 private:
  std::vector<uint32_t> order_;
  // Of order_: drawn again, after it, where it stands, so that nothing of it is ever seen.
  std::vector<uint8_t> hidden_;
  bool anyBlended_ = false;
  uint64_t instances_ = 0, materials_ = 0;  // revisions that it follows
};

}  // namespace latelight::render
