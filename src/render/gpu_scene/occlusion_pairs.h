// Pairs of textures that are one image on a CPU device: a map of occlusion, of which shaders read the red channel, and
// a metallic-roughness map, of which they read green and blue. Sampling is most of the time of the geometry pass there,
// and one sample then returns both (shared::kTraitSharedOcclusion).
#pragma once

#include <memory>
#include <vector>

#include "scene/scene.h"

namespace latelight::render {

struct OcclusionPairs {
  static constexpr int kNone = -1;
  std::vector<int> occlusionOf;  // by texture: the occlusion map whose red channel its image has, or kNone
  std::vector<int> imageOf;      // by texture: the texture whose image holds it, mostly itself
};

// Returns the pairs of textures that nothing else samples, neither another slot nor a material with only one of them.
// Both are linear and have the same size, because the red channel must be filtered as the texture it comes from.
OcclusionPairs occlusionPairs(const scene::Scene& scene);
// The same without any pairs.
OcclusionPairs noOcclusionPairs(const scene::Scene& scene);

// Returns all levels of a metallic-roughness map with the red channel of an occlusion map.
std::unique_ptr<std::byte[]> withOcclusion(const scene::Texture& metallicRoughness, const scene::Texture& occlusion);

}  // namespace latelight::render
