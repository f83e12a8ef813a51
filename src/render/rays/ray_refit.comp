#version 460
#extension GL_GOOGLE_include_directive : require
// Refits the boxes of a mesh's BVH to its deformed vertices, from the leaves to the root (Karras 2012, Maximizing
// Parallelism in the Construction of BVHs, Octrees, and k-d Trees, section 4). The topology is that of the mesh at
// rest. An invocation per node computes the boxes of the node's leaves. The invocation that completes the second box of
// a node continues with the node's parent, so boxes do not depend on the order of invocations. Y is the world, if each
// has vertices and nodes of its own.
#include "render/glsl/common.glsl"
#include "render/rays/refit_push.h"
#include "shared/rays.h"

layout(constant_id = kFencedConstant) const uint kFenced = 1;  // 0 on CPU devices

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer RayNodesRef { RayNode v[]; };

layout(push_constant, scalar) uniform Push { RayRefitPush push; };

uint64_t ownNodes;  // RayRefitPush::nodes of the invocation's world

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

void writeBox(uint index, bool second, RefitBox box) {
  RayNodesRef nodes = RayNodesRef(ownNodes);
  if (second) {
    nodes.v[index].lowB = box.low;
    nodes.v[index].highB = box.high;
  } else {
    nodes.v[index].lowA = box.low;
    nodes.v[index].highA = box.high;
  }
}

// Orders the boxes that this invocation has written before those that it reads. On a CPU device the atomic counter does
// that, and lavapipe ends invocations at a barrier that not all of a workgroup execute.
void orderBoxes() {
  if (kFenced != 0u) memoryBarrierBuffer();
}

// Counts refitted children of a node. Returns true if both are.
bool completes(uint index, uint children) {
  RayNodesRef nodes = RayNodesRef(ownNodes);
  orderBoxes();
  bool complete = atomicAdd(nodes.v[index].refitted, children) + children == 2u;
  if (complete) nodes.v[index].refitted = 0u;
  orderBoxes();
  return complete;
}

// Refits the parents of a complete node, until one has another child that is not refitted yet.
void refitParents(uint index) {
  RayNodesRef nodes = RayNodesRef(ownNodes);
  uint parent = nodes.v[index].parent;
  while (parent != kRayNone) {
    RefitBox box = RefitBox(min(nodes.v[index].lowA, nodes.v[index].lowB),
                            max(nodes.v[index].highA, nodes.v[index].highB));
    writeBox(parent, nodes.v[parent].b == index, box);
    index = parent;
    parent = completes(index, 1u) ? nodes.v[index].parent : kRayNone;
  }
}

void main() {
  uint index = gl_GlobalInvocationID.x, world = gl_GlobalInvocationID.y;
  if (index >= push.nodeCount) return;
  ownNodes = push.nodes + uint64_t(world) * push.nodeCount * kRayNodeBytes;
  uint64_t positions = MeshRef(push.meshes).v[push.mesh + world * push.meshStride].positions;
  uint a = RayNodesRef(ownNodes).v[index].a, b = RayNodesRef(ownNodes).v[index].b;
  bool leafA = (a & kRayLeaf) != 0u, leafB = (b & kRayLeaf) != 0u;
  if (leafA) writeBox(index, false, leafBox(positions, a));
  if (leafB && b != kRayNone) writeBox(index, true, leafBox(positions, b));
  if (!leafA && !leafB) return;
  if (completes(index, uint(leafA) + uint(leafB))) refitParents(index);
}
