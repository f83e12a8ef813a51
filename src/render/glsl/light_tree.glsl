// A subgroup's walk through the light tree (shared/types.h) with a box: comes to the leaves whose boxes meet it, in the
// order of their lights. Every lane tests a child; what is left of a group of siblings is a mask of bits, and the masks
// of the groups above are a stack that moves, so that no index into it is dynamic.
#include "render/glsl/lanes.glsl"

struct TreeWalk {
  vec3 low, high;  // the box
  uint group;      // of siblings: 0 is the root's children, h + 1 those of node h
  uint pending;    // the siblings still to come to
  uint above[6];   // those of the groups above, nearest first: a tree over 2^32 lights is 6 levels high
};

// Who votes yes, by rank among the lanes present. (A vote, not subgroupOr: NVIDIA's driver 580.159 lost bits of that in this
// loop, and with them the lists of `tiled`.)
uint votesByRank(bool vote) {
  uvec4 votes = subgroupBallot(vote);
#ifdef PARTIAL_SUBGROUPS  // before the include: in fragment shaders lanes are missing; compute's workgroups of 256 are full
  uint packed = 0u;
  while (anyLane(votes)) packed |= 1u << fromLane(laneRank, popLane(votes));
  return packed;
#else
  return votes.x;
#endif
}

// The children whose boxes meet the walk's.
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

// An empty walk where `on` is false.
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

// The next leaf, whose first light is `light`, or false at the end.
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
