// Prefilters an environment: represents it as a quadtree of point lights, and convolves it with GGX lobes.
//
// The usual method, importance sampling of filtered mips (Krivanek and Colbert 2008), produces noise or bias around a
// sun. Here each lobe is integrated over the full sphere by a quadrature that is fine where the lobe is narrow and
// coarse in its tails. The tree is traversed once per tile of output texels, and every node that is wide relative to
// its distance to the tile is opened (Barnes and Hut 1986). The remaining nodes are summed for every texel of the tile.
// The method is deterministic. A lamp of one pixel keeps its position and its energy, because a node is at the centroid
// of its light.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/environment/environment.h"
#include "scene/environment/picture_io.h"

namespace latelight::scene {

class EnvironmentTree {
 public:
  // `image` must be twice as wide as high, with a width that is a power of two of at least 16 and clamped radiance.
  explicit EnvironmentTree(const FloatImage& image);

  struct Node {
    glm::vec3 direction;  // unit: centroid of the light in the node
    float size;           // the larger of its angular extents, in radians
    glm::vec3 radiance;   // mean
    float solidAngle;
  };
  // Level 0 is the coarsest; each further level is twice as wide and high.
  struct Level {
    uint32_t width = 0, height = 0;
    std::vector<Node> nodes;
    const Node& at(size_t x, size_t y) const { return nodes[y * width + x]; }
  };
  const std::vector<Level>& levels() const { return levels_; }

 private:
  std::vector<Level> levels_;
};

enum class Lobe { Specular, Cosine };

// Converts the non-negative cosine between light and a lobe's axis to the light's weight, up to a constant factor. For
// a specular lobe of GGX's alpha, the weight is D(h) (n.l) for n = v = r (Karis 2013, "Real Shading in Unreal Engine
// 4"), divided by 1 + alpha^2 n.l. At alpha 1, where D is constant, this equals the lobe itself, which masking and
// shadowing flatten. `T` is float, double or a vector of them.
template <typename T>
void toLobeWeight(Lobe lobe, float alpha, T& c) {
  if (lobe == Lobe::Cosine) return;
  // Up to a factor, D(h) is 1 / ((1 - q) - q c)^2 with c = r.l and q = (1 - alpha^2) / 2.
  const float a2 = alpha * alpha, q = (1.0f - a2) * 0.5f, p = 1.0f - q;
  const T t = p - q * c;
  c /= t * t * (1.0f + a2 * c);
}

// An octahedral map to compute; its size is a multiple of 8.
struct LobeMap {
  Lobe lobe;
  float roughness;  // perceptual, above 0; 1 for a cosine lobe
  FloatImage* image;
};

// Fills the maps with radiance averaged by the lobe's weight. For the cosine lobe, this is irradiance / pi.
void convolve(const EnvironmentTree& tree, const std::vector<LobeMap>& maps);

}  // namespace latelight::scene
