// Writes a node and its leaves to where rays read them. Nodes are stored in depth-first order, the first child right
// after its parent, and so are the triangles of leaves.
#ifndef LATELIGHT_RAYS_PLACE_GLSL
#define LATELIGHT_RAYS_PLACE_GLSL
#include "render/rays/build/build.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer RayNodesRef { RayNode v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer RayTrianglesRef { RayTriangle v[]; };

void writeTriangle(BvhBuild build, BuildMesh mesh, uint reference, uint at) {
  uint triangle = BuildWordsRef(build.items[0]).v[reference & ~kRayLeaf] - mesh.first;
  UintRef indices = UintRef(mesh.indices);
  RayTrianglesRef(mesh.triangles).v[at] =
      RayTriangle(uint[3](indices.v[3u * triangle], indices.v[3u * triangle + 1u], indices.v[3u * triangle + 2u]),
                  triangle);
}

// Writes the triangles of a leaf, from `first` on, and returns the reference to it.
uint placeLeaf(BvhBuild build, BuildMesh mesh, uint reference, uint first) {
  uint stack[kMaxRayLeaf];
  uint top = 0u, count = 0u;
  stack[top++] = reference;
  while (top > 0u) {
    uint current = stack[--top];
    if (isItem(current)) {
      writeTriangle(build, mesh, current, first + count);
      ++count;
    } else {
      stack[top++] = BuildNodesRef(build.nodes).v[current].b;
      stack[top++] = BuildNodesRef(build.nodes).v[current].a;
    }
  }
  return kRayLeaf | count - 1u << kRayCountShift | first;
}

// Reserves entries in the queue of a level, and the workgroups that process them. Returns the first one of this
// invocation. All invocations must call it, because many atomic operations on one counter would take turns: a workgroup
// needs one. The order of nodes in a queue does not matter to the result.
shared uint firstOfGroup;
uint reserve(BvhBuild build, uint level, uint count) {
  BuildStateRef state = BuildStateRef(build.state);
  uint total, before = exclusiveScan(count, total);
  if (invocation() == 0u && total > 0u) {
    firstOfGroup = atomicAdd(state.v.placed[level], total);
    uvec3 groups = groupsOf(groupsFor(firstOfGroup + total, kBuildGroup));
    atomicMax(state.v.placeGroups[level].x, groups.x);
    atomicMax(state.v.placeGroups[level].y, groups.y);
  }
  barrier();
  return firstOfGroup + before;
}

void enqueue(BvhBuild build, uint level, uint slot, uint node, BuildPlace place) {
  BuildPlacesRef(build.places).v[node] = place;
  BuildWordsRef(build.queues[level & 1u]).v[slot] = node;
}

bool isLeaf(BvhBuild build, uint reference) {
  return isItem(reference) || (BuildNodesRef(build.nodes).v[reference].items & kBecomesLeaf) != 0u;
}

#endif
