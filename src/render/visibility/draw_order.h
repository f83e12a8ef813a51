// The order in which the graphics pipeline draws a scene, and the selection of the instances that a view draws.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "render/base/frustum.h"
#include "render/gpu_scene/gpu_scene.h"

namespace latelight::render {

// Instances with the same mesh, material and winding, drawn by one instanced draw.
struct Draw {
  uint32_t mesh = 0, material = 0;
  bool clockwise = false;
  bool vast = false;              // triangles are drawn as fans (kVastFan)
  uint32_t first = 0, count = 0;  // range of DrawList::instances
};

// Draws in the order in which they are recorded.
struct DrawList {
  std::vector<Draw> draws;
  std::vector<uint32_t> instances;  // indices in the scene
  bool empty() const { return draws.empty(); }
};

// Sorts instances by material, then mesh, then index, which reduces material changes and groups instances into few
// draws.
class DrawOrder {
 public:
  // Follows the scene's instances. Does nothing if no instance or material has changed.
  void update(const GpuScene& scene);

  enum class Kind { Solid, Blended };                          // opaque and masked; alpha-blended
  bool anyBlended() const { return anyBlended_; }              // in any world
  const std::vector<uint32_t>& all() const { return order_; }  // all instances, of both kinds
  // Returns the instances of a kind whose bounds `wanted` accepts; `wanted` is called on all threads. `group` restricts
  // the result to one group; 0 selects all. The instances are those of `world`.
  DrawList select(const GpuScene& scene, Kind kind, const std::function<bool(const Sphere&)>& wanted,
                  uint32_t group = 0, uint32_t world = 0) const;

 private:
  std::vector<uint32_t> order_;
  // Per element of order_: 1 if the next element is an identical copy in the same position, which hides this one
  // completely. Worlds may move the copies apart.
  std::vector<uint8_t> covered_;
  bool anyBlended_ = false;
  uint64_t instances_ = 0, materials_ = 0, worlds_ = 0;  // revisions of the last update
};

}  // namespace latelight::render
