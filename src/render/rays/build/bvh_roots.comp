#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the clusters that remain after the rounds to where the host reads them.
#include "render/rays/build/build.glsl"

layout(local_size_x = kBuildGroup) in;

void main() {
  uint index = workgroup() * kBuildGroup + invocation();
  BvhBuild build = BvhBuildRef(push.build).v;
  if (index >= build.target) return;
  BuildStateRef state = BuildStateRef(build.state);
  BuildResult result = BuildResult(BuildCluster(vec3(0.0), 0u, vec3(0.0), kRayNone), 1u, 0u);
  uint round = state.v.finished, count = state.v.clusters[round];
  if (index < count) {
    result.cluster = BuildClustersRef(clustersOf(build, round, count)).v[index];
    if (!isItem(result.cluster.reference)) {
      result.items = BuildNodesRef(build.nodes).v[result.cluster.reference].items;
      result.nodes = BuildNodesRef(build.nodes).v[result.cluster.reference].nodes;
    }
  }
  BuildResultsRef(build.results).v[index] = result;
}
