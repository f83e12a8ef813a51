#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the nodes of a level to their places, and places their children, which are the next level.
#include "render/rays/build/place.glsl"

layout(local_size_x = kBuildGroup) in;

uint itemsOf(BvhBuild build, uint reference) {
  return isItem(reference) ? 1u : BuildNodesRef(build.nodes).v[reference].items & ~kBecomesLeaf;
}

// Places a child whose subtree starts at node `index` and at triangle `first`. Returns the reference to it.
uint placeChild(BvhBuild build, BuildPlace parent, uint reference, uint index, uint first) {
  BuildMesh mesh = BuildMeshesRef(build.meshes).v[parent.mesh];
  if (isItem(reference) || (BuildNodesRef(build.nodes).v[reference].items & kBecomesLeaf) != 0u)
    return placeLeaf(build, mesh, reference, first);
  enqueue(build, push.step + 1u, reference, BuildPlace(index, first, parent.index, parent.mesh));
  return index;
}

void main() {
  uint item = workgroup() * kBuildGroup + invocation();
  BvhBuild build = BvhBuildRef(push.build).v;
  if (item >= BuildStateRef(build.state).v.placed[push.step]) return;
  uint index = BuildWordsRef(build.queues[push.step & 1u]).v[item];
  BuildPlace place = BuildPlacesRef(build.places).v[index];
  BuildNode node = BuildNodesRef(build.nodes).v[index];
  uint nodesOfA = isItem(node.a) ? 0u : BuildNodesRef(build.nodes).v[node.a].nodes;
  uint a = placeChild(build, place, node.a, place.index + 1u, place.first);
  uint b = placeChild(build, place, node.b, place.index + 1u + nodesOfA, place.first + itemsOf(build, node.a));
  RayNodesRef(BuildMeshesRef(build.meshes).v[place.mesh].nodes).v[place.index] =
      RayNode(node.lowA, a, node.highA, b, node.lowB, place.parent, node.highB, 0u);
}
