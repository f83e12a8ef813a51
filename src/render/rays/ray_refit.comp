#version 460
#extension GL_GOOGLE_include_directive : require
// Refits the boxes of a mesh's BVH to its deformed vertices, one level of nodes per dispatch, from the last level to
// the first. The topology is that of the mesh at rest. Each invocation updates one node (push.nodes) from the boxes of
// its children in the next level, or from the vertices of the triangles in its leaves.
#include "render/glsl/common.glsl"
#include "render/rays/refit_push.h"
#include "shared/rays.h"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer RayNodesRef { RayNode v[]; };

layout(push_constant, scalar) uniform Push { RayRefitPush push; };

struct RefitBox {
  vec3 low, high;
};

RefitBox leafBox(uint64_t positions, uint leaf) {
  RefitBox box = RefitBox(vec3(3.0e38), vec3(-3.0e38));
  uint first = leaf & kRayFirstMask, count = (leaf >> kRayCountShift & 7u) + 1u;
  for (uint i = first; i < first + count; ++i) {
    uvec4 triangle = wordsAt(push.triangles, i);
    for (uint corner = 0u; corner < 3u; ++corner) {
      vec3 at = positionAt(positions, triangle[corner]);
      box.low = min(box.low, at);
      box.high = max(box.high, at);
    }
  }
  return box;
}

RefitBox nodeBox(uint index) {
  RayNode node = RayNodesRef(push.nodes).v[index];
  if (node.b == kRayNone) return RefitBox(node.lowA, node.highA);
  return RefitBox(min(node.lowA, node.lowB), max(node.highA, node.highB));
}

RefitBox childBox(uint64_t positions, uint child) {
  if ((child & kRayLeaf) != 0u) return leafBox(positions, child);
  return nodeBox(child);
}

void main() {
  uint index = push.first + gl_GlobalInvocationID.x;
  if (index >= push.end) return;
  uint64_t positions = MeshRef(push.meshes).v[push.mesh].positions;
  RayNode node = RayNodesRef(push.nodes).v[index];
  RefitBox a = childBox(positions, node.a);
  RayNodesRef(push.nodes).v[index].lowA = a.low;
  RayNodesRef(push.nodes).v[index].highA = a.high;
  if (node.b == kRayNone) return;
  RefitBox b = childBox(positions, node.b);
  RayNodesRef(push.nodes).v[index].lowB = b.low;
  RayNodesRef(push.nodes).v[index].highB = b.high;
}
