#version 460
#extension GL_GOOGLE_include_directive : require
// Places the root of each mesh, or writes the only node of a mesh that is one leaf.
#include "render/rays/build/place.glsl"

layout(local_size_x = kBuildGroup) in;

BuildBox boxOf(BvhBuild build, BuildMesh mesh) {
  if (isItem(mesh.root))
    return triangleBox(mesh, BuildWordsRef(build.items[0]).v[mesh.root & ~kRayLeaf] - mesh.first);
  BuildNode node = BuildNodesRef(build.nodes).v[mesh.root];
  return BuildBox(min(node.lowA, node.lowB), max(node.highA, node.highB));
}

void main() {
  uint index = workgroup() * kBuildGroup + invocation();
  BvhBuild build = BvhBuildRef(push.build).v;
  BuildMesh mesh = BuildMeshesRef(build.meshes).v[min(index, build.meshCount - 1u)];
  bool leaf = isLeaf(build, mesh.root), isMesh = index < build.meshCount;
  uint slot = reserve(build, 0u, uint(isMesh && !leaf));
  if (!isMesh) return;
  if (!leaf) {
    enqueue(build, 0u, slot, mesh.root, BuildPlace(0u, 0u, kRayNone, index));
    return;
  }
  BuildBox box = boxOf(build, mesh);
  uint reference = placeLeaf(build, mesh, mesh.root, 0u);
  RayNodesRef(mesh.nodes).v[0] =
      RayNode(box.low, reference, box.high, kRayNone, vec3(0.0), kRayNone, vec3(0.0), 0u);
}
