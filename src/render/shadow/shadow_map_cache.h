// Shadow map cache: shadow maps in an atlas that persists across frames. A map is reused until its light, the region
// that it covers, or a shadow caster in that region changes.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "render/base/frustum.h"
#include "render/gpu_scene/gpu_scene.h"
#include "render/shadow/atlas.h"
#include "render/shadow/plan.h"
#include "vk/resources.h"

namespace latelight::render {

struct CachedShadowMap {
  AtlasTile tile;
  Frustum frustum;               // objects outside cast no shadows into the map
  std::optional<Sphere> within;  // the same for objects outside this sphere
  bool drawn = false;            // some of its pages have been drawn
  bool whole = false;            // all of its pages have been drawn
  uint32_t drawings = 0;         // number of pictures that have drawn it
  uint64_t frame = 0;            // number of the last frame that requested it
};

class ShadowMapCache {
 public:
  struct Request {
    std::string key;  // everything except the scene that determines the map's contents; equal keys mean equal maps
    const ShadowView* view;
  };

  // Drops the maps that changes to the scene have invalidated. Worlds usually change in every frame, so they drop all
  // maps, as does the first frame without worlds after them.
  void follow(const GpuScene& scene);
  // Drops all maps and frees all tiles: those of the next place() depend on its requests only.
  void reset();

  // Places all of these maps in tiles of one atlas and returns them in the same order. Cached maps keep their tiles.
  // All keys must be different. `kind` states the format and usage of the atlas.
  std::vector<std::shared_ptr<CachedShadowMap>> place(vk::Device& device, const vk::ImageDesc& kind,
                                                      std::span<const Request> requested);
  const std::shared_ptr<const vk::Image>& atlas() const { return atlas_; }
  const std::shared_ptr<const vk::Buffer>& pages() const { return pages_; }  // drawn pages: words (page_push.h)
  bool anyDrawn() const;
  std::vector<AtlasTile> tiles() const;  // of all cached maps

 private:
  struct Caster {
    Sphere bounds;
    uint64_t record, shape;  // hash of the instance's record; revision of its mesh
    bool operator==(const Caster& other) const;
  };
  std::vector<Sphere> changedCasters(const GpuScene& scene);
  void forget();  // drops all maps
  bool holds(const vk::ImageDesc& kind, uint64_t texels, uint32_t largest);
  void renew(vk::Device& device, vk::ImageDesc kind, uint64_t texels, uint32_t largest);
  std::vector<std::shared_ptr<CachedShadowMap>> tryPlace(std::span<const Request> requested);
  std::shared_ptr<CachedShadowMap> add(const Request& requested);
  void dropUnrequested();

  std::shared_ptr<const vk::Image> atlas_;
  std::shared_ptr<const vk::Buffer> pages_;
  AtlasTiles tiles_{0, 0};
  std::unordered_map<std::string, std::shared_ptr<CachedShadowMap>> maps_;
  uint64_t frame_ = 0;
  bool isReset_ = false;          // since the last place()
  uint32_t oversizedFrames_ = 0;  // consecutive frames for which the atlas was much too large
  std::vector<Caster> casters_;
  glm::dvec3 origin_{0};  // of the positions in casters_
  bool hadWorlds_ = false;
  uint64_t instances_ = 0, shapes_ = 0, materials_ = 0;  // revisions of the scene that the maps represent
};

}  // namespace latelight::render
