// Traversal of the light tree, a BVH over lights (shared/types.h), by a subgroup: visits the leaves whose boxes overlap
// a query box, in the order of their lights. Each lane tests one child. The remaining siblings of a node are a bit
// mask; the masks of its ancestors are a stack that is shifted, so that it needs no dynamic indexing.
#include "render/glsl/lanes.glsl"

struct TreeWalk {
  vec3 low, high;  // the query box
  uint group;      // sibling group: 0 for the root's children, h + 1 for those of node h
  uint pending;    // siblings to visit
  uint above[6];   // pending masks of the ancestors, nearest first: a tree over 2^32 lights has 6 levels
};

// Returns the votes as bits by lane index (laneRank). It uses a ballot instead of subgroupOr, because NVIDIA's driver
// loses bits of subgroupOr in this loop, which breaks the light lists of `tiled`.
uint votesByRank(bool vote) {
  uvec4 votes = subgroupBallot(vote);
#ifdef PARTIAL_SUBGROUPS  // define before the include: for fragment shaders; compute workgroups of 256 are full
  uint packed = 0u;
  while (anyLane(votes)) packed |= 1u << fromLane(laneRank, popLane(votes));
  return packed;
#else
  return votes.x;
#endif
}

// Returns the children whose boxes overlap the query box.
uint childrenMet(FrameConstants frame, TreeWalk walk) {
  uint met = 0u;
  for (uint first = 0u; first < kLightTreeWidth; first += lanesPresent) {
    uint child = first + laneRank;
    LightBox box = frameLightBox(frame, walk.group * kLightTreeWidth + min(child, kLightTreeWidth - 1u));
    bool meets = child < kLightTreeWidth && all(lessThanEqual(box.low, walk.high)) &&
                 all(lessThanEqual(walk.low, box.high));
    met |= votesByRank(meets) << first;
  }
  return met;
}

// Starts a traversal, which is empty if `on` is false.
TreeWalk startWalk(FrameConstants frame, vec3 low, vec3 high, bool on) {
  TreeWalk walk = TreeWalk(low, high, 0u, 0u, uint[6](0u, 0u, 0u, 0u, 0u, 0u));
  if (on) walk.pending = childrenMet(frame, walk);
  return walk;
}

void descend(inout TreeWalk walk, FrameConstants frame, uint node) {
  for (int i = 5; i > 0; --i) walk.above[i] = walk.above[i - 1];
  walk.above[0] = walk.pending;
  walk.group = node + 1u;
  walk.pending = childrenMet(frame, walk);
}

void ascend(inout TreeWalk walk) {
  walk.pending = walk.above[0];
  for (int i = 0; i < 5; ++i) walk.above[i] = walk.above[i + 1];
  walk.above[5] = 0u;
  walk.group = (walk.group - 1u) >> kLightTreeBits;
}

// Visits the next leaf; `light` is its first light. Returns false at the end.
bool nextLeaf(inout TreeWalk walk, FrameConstants frame, out uint light) {
  light = 0u;
  bool found = false;
  while (!found) {
    while (walk.pending == 0u && walk.group != 0u) ascend(walk);
    if (walk.pending == 0u) break;
    uint node = walk.group * kLightTreeWidth + uint(findLSB(walk.pending));
    walk.pending &= walk.pending - 1u;
    found = node >= frame.lightTreeLeaves;
    if (found)
      light = frame.directionalLights + (node - frame.lightTreeLeaves) * kLightTreeWidth;
    else
      descend(walk, frame, node);
  }
  return found;
}
