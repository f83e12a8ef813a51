// Shadow maps in an atlas that outlives the frame: a light's maps stay there until the light, or what casts shadows
// within its reach, changes.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "render/gpu_scene.h"
#include "render/shadow/atlas.h"
#include "vk/resources.h"

namespace latelight::render {

// All maps of a light, which are drawn together.
struct KeptMaps {
  std::vector<AtlasTile> tiles;
  std::optional<Sphere> within;  // nothing outside casts shadows into them
  bool drawn = false;            // the device has them, whole
  uint64_t frame = 0;            // that has asked for them last
};

class KeptShadowMaps {
 public:
  struct Wanted {
    std::string key;  // whatever decides what is in the maps but the scene: equal ones are the same maps
    uint32_t maps, size;
    std::optional<Sphere> within;
  };

  // Forgets the maps that no longer show the scene.
  void follow(const GpuScene& scene);
  void forget();

  // Tiles of one atlas for all of these, of which none has the key of another. `kind`: format and usage.
  std::vector<std::shared_ptr<KeptMaps>> place(vk::Device& device, const vk::ImageDesc& kind,
                                               std::span<const Wanted> wanted);
  const std::shared_ptr<const vk::Image>& atlas() const { return atlas_; }
  bool anyDrawn() const;

 private:
  struct Caster {
    Sphere bounds;
    uint64_t record, shape;  // what else there is of the instance; its mesh's revision
    bool operator==(const Caster& other) const;
  };
  std::vector<Sphere> changedCasters(const GpuScene& scene);
  bool holds(const vk::ImageDesc& kind, uint64_t texels, uint32_t largest);
  void renew(vk::Device& device, vk::ImageDesc kind, uint64_t texels, uint32_t largest);
  std::vector<std::shared_ptr<KeptMaps>> tryPlace(std::span<const Wanted> wanted);
  std::shared_ptr<KeptMaps> add(const Wanted& wanted);
  void dropUnasked();

  std::shared_ptr<const vk::Image> atlas_;
  AtlasTiles tiles_{0, 0};
  std::unordered_map<std::string, std::shared_ptr<KeptMaps>> maps_;
  uint64_t frame_ = 0;
  uint32_t tooLarge_ = 0;  // frames in a row for which the atlas was much too large
  std::vector<Caster> casters_;
  uint64_t instances_ = 0, shapes_ = 0, materials_ = 0;  // revisions of the scene that the maps show
};

}  // namespace latelight::render
