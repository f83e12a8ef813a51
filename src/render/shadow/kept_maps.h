// Shadow maps in an atlas that outlives the frame: a map stays there until its light, the part of the world that it
// shows, or what casts shadows in that part changes.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "render/frustum.h"
#include "render/gpu_scene.h"
#include "render/shadow/atlas.h"
#include "render/shadow/plan.h"
#include "vk/resources.h"

namespace latelight::render {

struct KeptMap {
  AtlasTile tile;
  Frustum frustum;               // nothing outside casts shadows into it,
  std::optional<Sphere> within;  // nor outside of this
  bool drawn = false;            // the device has some of its pages,
  bool whole = false;            // or all
  uint32_t drawings = 0;         // frames that have been drawing it
  uint64_t frame = 0;            // that has asked for it last
};

class KeptShadowMaps {
 public:
  struct Wanted {
    std::string key;  // whatever decides what is in the map but the scene: those of equal keys are the same map
    const ShadowView* view;
  };

  // Forgets the maps that no longer show the scene.
  void follow(const GpuScene& scene);
  void forget();

  // Tiles of one atlas for all of these, of which none has the key of another. `kind`: format and usage.
  std::vector<std::shared_ptr<KeptMap>> place(vk::Device& device, const vk::ImageDesc& kind,
                                              std::span<const Wanted> wanted);
  const std::shared_ptr<const vk::Image>& atlas() const { return atlas_; }
  const std::shared_ptr<const vk::Buffer>& pages() const { return pages_; }  // that are drawn: words (page_push.h)
  bool anyDrawn() const;
  std::vector<AtlasTile> tiles() const;  // of its maps

 private:
  struct Caster {
    Sphere bounds;
    uint64_t record, shape;  // what else there is of the instance; its mesh's revision
    bool operator==(const Caster& other) const;
  };
  std::vector<Sphere> changedCasters(const GpuScene& scene);
  bool holds(const vk::ImageDesc& kind, uint64_t texels, uint32_t largest);
  void renew(vk::Device& device, vk::ImageDesc kind, uint64_t texels, uint32_t largest);
  std::vector<std::shared_ptr<KeptMap>> tryPlace(std::span<const Wanted> wanted);
  std::shared_ptr<KeptMap> add(const Wanted& wanted);
  void dropUnasked();

  std::shared_ptr<const vk::Image> atlas_;
  std::shared_ptr<const vk::Buffer> pages_;
  AtlasTiles tiles_{0, 0};
  std::unordered_map<std::string, std::shared_ptr<KeptMap>> maps_;
  uint64_t frame_ = 0;
  uint32_t tooLarge_ = 0;  // frames in a row for which the atlas was much too large
  std::vector<Caster> casters_;
  glm::dvec3 origin_{0};  // of the positions in those
  uint64_t instances_ = 0, shapes_ = 0, materials_ = 0;  // revisions of the scene that the maps show
};

}  // namespace latelight::render
