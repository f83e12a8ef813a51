#version 460
#extension GL_GOOGLE_include_directive : require
// Merges clusters with their partners, in the place of the first one, and writes the nodes of the merged pairs. The
// order of clusters stays.
#include "render/rays/build/build.glsl"

layout(local_size_x = kMergedPerGroup) in;

// Returns the numbers of triangles and of inner nodes of a subtree.
uvec2 sizeOf(BvhBuild build, uint reference) {
  if (isItem(reference)) return uvec2(1u, 0u);
  BuildNodesRef nodes = BuildNodesRef(build.nodes);
  return uvec2(nodes.v[reference].items & ~kBecomesLeaf, nodes.v[reference].nodes);
}

BuildNode nodeOf(BvhBuild build, BuildCluster a, BuildCluster b) {
  uvec2 sizeA = sizeOf(build, a.reference), sizeB = sizeOf(build, b.reference);
  uint items = sizeA.x + sizeB.x;
  float area = boxArea(min(a.low, b.low), max(a.high, b.high));
  float children = float(sizeA.x) * boxArea(a.low, a.high) + float(sizeB.x) * boxArea(b.low, b.high);
  bool leaf = becomesLeaf(items, area, children);
  return BuildNode(a.low, a.reference, a.high, b.reference, b.low, leaf ? items | kBecomesLeaf : items, b.high,
                   leaf ? 0u : sizeA.y + sizeB.y + 1u);
}

BuildCluster merged(BuildCluster a, BuildCluster b, uint node) {
  uint height = max(a.mesh & kHeightMask, b.mesh & kHeightMask) + 1u;
  return BuildCluster(min(a.low, b.low), node, max(a.high, b.high), (a.mesh & ~kHeightMask) | height);
}

void main() {
  BvhBuild build = BvhBuildRef(push.build).v;
  uint count = BuildStateRef(build.state).v.clusters[push.step], groups = groupsFor(count, kMergedPerGroup);
  if (workgroup() >= groups) return;
  BuildWordsRef counters = BuildWordsRef(build.counters);
  BuildClustersRef from = BuildClustersRef(clustersOf(build, push.step, count));
  uint index = workgroup() * kMergedPerGroup + invocation();
  uint partner = index < count ? BuildWordsRef(build.partners).v[index] : 0u;
  bool stays = index < count && partner >= index, merges = index < count && partner > index;
  uint total, before = exclusiveScan(uint(stays) | uint(merges) << 16, total);
  if (!stays) return;
  uint remaining = counters.v[groups];  // clusters after this round: the sum before the first count of pairs
  uint node = (build.count - count) + (counters.v[groups + workgroup()] - remaining) + (before >> 16);
  BuildCluster cluster = from.v[index];
  if (merges) {
    BuildCluster other = from.v[partner];
    BuildNodesRef(build.nodes).v[node] = nodeOf(build, cluster, other);
    cluster = merged(cluster, other, node);
  }
  BuildClustersRef to = BuildClustersRef(clustersOf(build, push.step + 1u, remaining));
  to.v[counters.v[workgroup()] + (before & 0xffffu)] = cluster;
}
