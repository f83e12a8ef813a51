#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the nodes of a level to their places, and places their children, which are the next level.
#include "render/rays/build/place.glsl"

layout(local_size_x = kBuildGroup) in;

uint itemsOf(BvhBuild build, uint reference) {
  return isItem(reference) ? 1u : BuildNodesRef(build.nodes).v[reference].items & ~kBecomesLeaf;
}

// Places a child whose subtree starts at node `index` and at triangle `first`. An inner node gets the entry `slot` of
// the next level's queue. Returns the reference to the child.
uint placeChild(BvhBuild build, BuildPlace parent, uint reference, bool leaf, uint slot, uint index, uint first) {
  if (leaf) return placeLeaf(build, BuildMeshesRef(build.meshes).v[parent.mesh], reference, first);
  enqueue(build, push.step + 1u, slot, reference, BuildPlace(index, first, parent.index, parent.mesh));
  return index;
}

void placeChildren(BvhBuild build, BuildPlace place, BuildNode node, bvec2 leaves, uint slot) {
  uint nodesOfA = isItem(node.a) ? 0u : BuildNodesRef(build.nodes).v[node.a].nodes;
  uint indexB = place.index + 1u + nodesOfA, firstB = place.first + itemsOf(build, node.a);
  uint a = placeChild(build, place, node.a, leaves.x, slot, place.index + 1u, place.first);
  uint b = placeChild(build, place, node.b, leaves.y, slot + uint(!leaves.x), indexB, firstB);
  RayNodesRef(BuildMeshesRef(build.meshes).v[place.mesh].nodes).v[place.index] =
      RayNode(node.lowA, a, node.highA, b, node.lowB, place.parent, node.highB, 0u);
}

void main() {
  uint item = workgroup() * kBuildGroup + invocation();
  BvhBuild build = BvhBuildRef(push.build).v;
  bool isNode = item < BuildStateRef(build.state).v.placed[push.step];
  BuildPlace place;
  BuildNode node;
  bvec2 leaves = bvec2(true);
  if (isNode) {
    uint index = BuildWordsRef(build.queues[push.step & 1u]).v[item];
    place = BuildPlacesRef(build.places).v[index];
    node = BuildNodesRef(build.nodes).v[index];
    leaves = bvec2(isLeaf(build, node.a), isLeaf(build, node.b));
  }
  uint slot = reserve(build, push.step + 1u, uint(!leaves.x) + uint(!leaves.y));
  if (isNode) placeChildren(build, place, node, leaves, slot);
}
