#version 460
#extension GL_GOOGLE_include_directive : require
// Finds the partner of each cluster, with which it merges in this round: of the clusters next to it, the one whose
// common box has the smallest area. Two clusters merge if each is the other's partner (Meister and Bittner 2018,
// section 3). At equal areas the partner is the one whose index differs in the lowest bits. This order is the same from
// both sides, so the best pair of a mesh always merges, and of many equal boxes half merge in one round.
//
// Writes build.partners, where a cluster that does not merge is its own partner, and counts per workgroup: clusters
// after the round, then, for all workgroups, merged pairs.
//
// The number of rounds and the depth of trees have a bound, whatever the boxes are. Let B be the number of clusters,
// minus the number of meshes, plus 1, which is at least the number of clusters of any mesh. Two clusters may merge if
// the height of the result is at most build.maxDepth - ceil(log2(B)). Once only ceil(log2(B)) rounds remain, the
// clusters of each mesh merge in pairs of neighbors. That halves B - 1, so it completes all trees in these rounds and
// keeps to the height. The host has the remaining levels for the nodes above clusters (build.target).
#include "render/rays/build/build.glsl"

layout(local_size_x = kBuildGroup) in;

const uint kLoaded = kBuildGroup + 2u * kNeighbors;
shared vec3 lows[kLoaded], highs[kLoaded];
shared uint meshes[kLoaded];
shared uint partners[kBuildGroup];  // indices in `lows`
shared uint groupCounts[2];

const uint kNoMesh = 0xffffffffu;

// Position 0 of the shared arrays has the index `first`.
void loadClusters(BuildClustersRef clusters, int first, uint count) {
  for (uint i = invocation(); i < kLoaded; i += kBuildGroup) {
    int index = first + int(i);
    meshes[i] = kNoMesh;
    if (index < 0 || index >= int(count)) continue;
    BuildCluster cluster = clusters.v[index];
    lows[i] = cluster.low;
    highs[i] = cluster.high;
    meshes[i] = cluster.mesh;
  }
}

uint nearest(uint self, uint maxHeight, int first) {
  uint best = self, bestArea = kNoMesh, bestOrder = kNoMesh;
  vec3 low = lows[self], high = highs[self];
  uint mesh = meshes[self] >> kHeightBits;
  if (meshes[self] == kNoMesh || (meshes[self] & kHeightMask) >= maxHeight) return self;
  for (uint other = self - kNeighbors; other <= self + kNeighbors; ++other) {
    if (other == self || meshes[other] >> kHeightBits != mesh || (meshes[other] & kHeightMask) >= maxHeight) continue;
    uint area = floatBitsToUint(boxArea(min(low, lows[other]), max(high, highs[other])));
    uint order = uint(first + int(self)) ^ uint(first + int(other));
    if (area > bestArea || (area == bestArea && order > bestOrder)) continue;
    best = other;
    bestArea = area;
    bestOrder = order;
  }
  return best;
}

// Returns the index of the first cluster of a mesh. Clusters are in the order of meshes.
uint firstOfMesh(BuildClustersRef clusters, uint mesh, uint count) {
  uint low = 0u, high = count;
  while (low < high) {
    uint middle = (low + high) / 2u;
    if (clusters.v[middle].mesh >> kHeightBits < mesh) low = middle + 1u;
    else high = middle;
  }
  return low;
}

// The first two clusters of a mesh are a pair, and so on.
uint pairedWith(BuildClustersRef clusters, uint self, uint index, uint count) {
  if (meshes[self] == kNoMesh) return self;
  uint mesh = meshes[self] >> kHeightBits, firstIndex = firstOfMesh(clusters, mesh, count);
  uint other = ((index - firstIndex) & 1u) == 0u ? self + 1u : self - 1u;
  return meshes[other] >> kHeightBits == mesh ? other : self;
}

void main() {
  BvhBuild build = BvhBuildRef(push.build).v;
  uint count = BuildStateRef(build.state).v.clusters[push.step], groups = groupsFor(count, kMergedPerGroup);
  if (workgroup() >= groups) return;
  BuildClustersRef clusters = BuildClustersRef(clustersOf(build, push.step, count));
  int first = int(workgroup() * kMergedPerGroup) - 2 * int(kNeighbors);
  if (invocation() < 2u) groupCounts[invocation()] = 0u;
  loadClusters(clusters, first, count);
  barrier();
  uint local = invocation(), self = local + kNeighbors, index = uint(first + int(self));
  uint needed = ceilLog2(count - build.meshCount + 1u);
  bool paired = build.rounds - push.step <= needed;
  partners[local] = paired ? pairedWith(clusters, self, index, count) : nearest(self, build.maxDepth - needed, first);
  barrier();
  bool inGroup = local >= kNeighbors && local < kNeighbors + kMergedPerGroup && index < count;
  uint partner = partners[local];
  if (inGroup && partners[partner - kNeighbors] != self) partner = self;
  if (inGroup) BuildWordsRef(build.partners).v[index] = uint(first + int(partner));
  if (inGroup && partner >= self) atomicAdd(groupCounts[0], 1u);
  if (inGroup && partner > self) atomicAdd(groupCounts[1], 1u);
  barrier();
  if (local < 2u) BuildWordsRef(build.counters).v[local * groups + workgroup()] = groupCounts[local];
}
