// Prefilters environments with a tree of lights; scene/environment/tree.h describes the algorithm.
#include "scene/environment/tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/log.h"
#include "base/parallel.h"
#include "scene/environment/octahedral_map.h"
#include "scene/vector_clones.h"

namespace latelight::scene {
namespace {

using TreeNode = EnvironmentTree::Node;
using Level = EnvironmentTree::Level;

constexpr double kTau = 2.0 * std::numbers::pi;

// --- the tree -------------------------------------------------------------------------------------------------------

// Angular extents of the nodes of a row.
struct Band {
  double middle, size, solidAngle;
};

Band band(uint32_t row, const Level& level) {
  const double step = std::numbers::pi / level.height, width = kTau / level.width;
  const double top = row * step, bottom = top + step;
  const double widest =
      top < std::numbers::pi / 2 && bottom > std::numbers::pi / 2 ? 1.0 : std::max(std::sin(top), std::sin(bottom));
  return {(top + bottom) * 0.5, std::max(step, width * widest), width * (std::cos(top) - std::cos(bottom))};
}

glm::vec3 direction(double polar, double azimuth) {
  return glm::vec3(std::sin(polar) * std::cos(azimuth), -std::sin(polar) * std::sin(azimuth), std::cos(polar));
}

// Column 0 begins at u = 0: half a turn before +X, which is the image's center (shared/environment.h).
double azimuth(uint32_t column, uint32_t width) {
  return (column + 0.5) * kTau / width - std::numbers::pi;
}

Level leaves(const FloatImage& image) {
  Level level{image.width, image.height, std::vector<TreeNode>(size_t{image.width} * image.height)};
  std::vector<glm::vec2> circle(image.width);
  for (uint32_t x = 0; x < image.width; ++x)
    circle[x] = glm::vec2(direction(std::numbers::pi / 2, azimuth(x, image.width)));
  parallelFor(image.height, 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const Band b = band(static_cast<uint32_t>(y), level);
      const auto sine = static_cast<float>(std::sin(b.middle)), cosine = static_cast<float>(std::cos(b.middle));
      for (size_t x = 0; x < image.width; ++x) {
        const float* p = image.at(x, y);
        level.nodes[y * image.width + x] = {glm::vec3(circle[x] * sine, cosine), static_cast<float>(b.size),
                                            glm::vec3(p[0], p[1], p[2]), static_cast<float>(b.solidAngle)};
      }
    }
  });
  return level;
}

// Merges four nodes at the centroid of their light. The small constant selects the geometric center if there is no
// light.
TreeNode merge(const std::array<const TreeNode*, 4>& children, const Band& b) {
  TreeNode node{glm::vec3(0), static_cast<float>(b.size), glm::vec3(0), static_cast<float>(b.solidAngle)};
  float whole = 0;
  for (const TreeNode* child : children) {
    const float power = (child->radiance.x + child->radiance.y + child->radiance.z + 1e-6f) * child->solidAngle;
    node.direction += child->direction * power;
    node.radiance += child->radiance * child->solidAngle;
    whole += child->solidAngle;
  }
  node.direction = glm::normalize(node.direction);
  node.radiance /= whole;
  return node;
}

Level parents(const Level& children) {
  Level level{children.width / 2, children.height / 2, std::vector<TreeNode>(children.nodes.size() / 4)};
  parallelFor(level.height, 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const Band b = band(static_cast<uint32_t>(y), level);
      for (size_t x = 0; x < level.width; ++x) {
        const TreeNode* upper = &children.at(2 * x, 2 * y);
        const TreeNode* lower = &children.at(2 * x, 2 * y + 1);
        level.nodes[y * level.width + x] = merge({upper, upper + 1, lower, lower + 1}, b);
      }
    }
  });
  return level;
}

// --- the quadrature -------------------------------------------------------------------------------------------------

constexpr uint32_t kTile = 8;  // output texels along a side of a tile

// A node is opened while it is wider than both kOpening times its distance to the tile and kFinest times the lobe's
// half width, which is capped at 0.4 radians, because even a wide lobe ends at its horizon with the slope of a cosine.
// Compared with using only leaves, sunlit and indoor environments differ by 0.1% on average and 0.5% at worst, less
// than one step of 8 bits.
constexpr float kOpening = 0.18f, kFinest = 0.25f, kWidest = 0.4f;

struct Tile {
  glm::vec3 axis;
  float radius;  // chord radius of the cap that contains its texels' centers
  std::array<glm::vec3, kTile * kTile> directions;
};

Tile makeTile(uint32_t left, uint32_t top, uint32_t size) {
  Tile tile{};
  for (uint32_t i = 0; i < kTile * kTile; ++i) {
    // The row and column beyond the edge are copied later, so their lanes repeat the edge.
    const uint32_t x = std::min(left + i % kTile, size - 2), y = std::min(top + i / kTile, size - 2);
    tile.directions[i] = mapDirection(static_cast<float>(x), static_cast<float>(y), size);
    tile.axis += tile.directions[i];
  }
  tile.axis = glm::normalize(tile.axis);
  for (const glm::vec3& d : tile.directions) tile.radius = std::max(tile.radius, glm::length(d - tile.axis));
  return tile;
}

// Collects the nodes whose sum approximates the environment for this tile's lobes, in traversal order.
class Walk {
 public:
  Walk(const std::vector<Level>& levels, const Tile& tile, float halfWidth, std::vector<TreeNode>& nodes)
      : levels_(levels), tile_(tile), halfWidth_(halfWidth), nodes_(nodes) {
    nodes_.clear();
    for (uint32_t y = 0; y < levels[0].height; ++y) {
      for (uint32_t x = 0; x < levels[0].width; ++x) visit(0, x, y);
    }
  }

 private:
  void visit(size_t level, uint32_t x, uint32_t y) {
    const TreeNode& node = levels_[level].at(x, y);
    // The node and its contents are below the horizon of every texel: a node extends at most 1.5 times its size from
    // its center.
    if (glm::dot(node.direction, tile_.axis) < -(tile_.radius + 1.5f * node.size)) return;
    const float distance = glm::length(node.direction - tile_.axis) - tile_.radius;
    if (level + 1 == levels_.size() ||
        node.size <= std::max(kOpening * distance, kFinest * std::min(halfWidth_, kWidest))) {
      nodes_.push_back(node);
      return;
    }
    visit(level + 1, 2 * x, 2 * y);
    visit(level + 1, 2 * x + 1, 2 * y);
    visit(level + 1, 2 * x, 2 * y + 1);
    visit(level + 1, 2 * x + 1, 2 * y + 1);
  }

  const std::vector<Level>& levels_;
  const Tile& tile_;
  const float halfWidth_;
  std::vector<TreeNode>& nodes_;
};

constexpr uint32_t kLanes = 8;
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));

LATELIGHT_VECTOR_CLONES void sumNodes(const std::vector<TreeNode>& nodes, Lobe lobe, float alpha, const Tile& tile,
                                      glm::vec4* sums) {
  for (uint32_t group = 0; group < kTile * kTile; group += kLanes) {
    Lanes x, y, z;
    for (uint32_t i = 0; i < kLanes; ++i) {
      const glm::vec3& d = tile.directions[group + i];
      x[i] = d.x, y[i] = d.y, z[i] = d.z;
    }
    Lanes red{}, green{}, blue{}, whole{};
    for (const TreeNode& node : nodes) {
      const Lanes c = x * node.direction.x + y * node.direction.y + z * node.direction.z;
      Lanes weight = c > 0.0f ? c : Lanes{};
      toLobeWeight(lobe, alpha, weight);
      weight *= node.solidAngle;
      red += weight * node.radiance.x;
      green += weight * node.radiance.y;
      blue += weight * node.radiance.z;
      whole += weight;
    }
    for (uint32_t i = 0; i < kLanes; ++i) sums[group + i] = glm::vec4(red[i], green[i], blue[i], whole[i]);
  }
}

struct TileJob {
  const LobeMap* map;
  uint32_t left, top;
};

void convolveTile(const EnvironmentTree& tree, const TileJob& job, std::vector<TreeNode>& nodes) {
  const float alpha = job.map->roughness * job.map->roughness;
  const Tile tile = makeTile(job.left, job.top, job.map->image->width);
  // D falls to half at tan(half vector's angle) = 0.64 alpha, and the lobe is twice as wide.
  const Walk walk(tree.levels(), tile, 2.0f * std::atan(0.64f * alpha), nodes);
  std::array<glm::vec4, kTile * kTile> sums;
  sumNodes(nodes, job.map->lobe, alpha, tile, sums.data());
  for (uint32_t i = 0; i < kTile * kTile; ++i) {
    const glm::vec4 mean(glm::vec3(sums[i]) / sums[i].w, 1.0f);
    setTexel(*job.map->image, job.left + i % kTile, job.top + i / kTile, mean);
  }
}

}  // namespace

EnvironmentTree::EnvironmentTree(const FloatImage& image) {
  levels_.push_back(leaves(image));
  while (levels_.back().width > 8) levels_.push_back(parents(levels_.back()));
  std::reverse(levels_.begin(), levels_.end());
}

void convolve(const EnvironmentTree& tree, const std::vector<LobeMap>& maps) {
  std::vector<TileJob> jobs;
  for (const LobeMap& map : maps) {
    for (uint32_t y = 0; y < map.image->height; y += kTile) {
      for (uint32_t x = 0; x < map.image->width; x += kTile) jobs.push_back({&map, x, y});
    }
  }
  Progress progress("Filtering the environment", jobs.size());
  parallelFor(jobs.size(), 8, [&](size_t begin, size_t end) {
    std::vector<TreeNode> nodes;
    for (size_t i = begin; i < end; ++i) convolveTile(tree, jobs[i], nodes), progress.step();
  });
  for (const LobeMap& map : maps) closeSeams(*map.image);
}

}  // namespace latelight::scene
