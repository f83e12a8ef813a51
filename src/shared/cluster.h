// Clusters (meshlets): groups of up to 128 adjacent triangles of a mesh, with the vertices that they share. A cluster
// is culled as a unit, and one workgroup rasterizes it.
#ifndef LATELIGHT_SHARED_CLUSTER_H
#define LATELIGHT_SHARED_CLUSTER_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kClusterTriangles = 128u;  // every cluster of a mesh has this many, except the last
SH_CONST uint kClusterVertices = 384u;   // maximum, if no two triangles share a vertex

struct Cluster {  // 68 bytes; object space
  vec3 center;    // center of the bounding sphere and of the bounding box
  float radius;
  vec3 extent;   // half extent of the bounding box
  float edge;    // length of the longest triangle edge
  vec3 apex;     // apex of the backface cone: see clusterFacesAway()
  float cutoff;  // 1: the cluster has no backface cone, since its normals face all directions
  vec3 axis;
  uint firstVertex;  // index into MeshClusters::positions or vertices
  uint vertices;
};

struct ClusterTriangle {
  uint corners;  // three indices into the cluster's vertices: clusterCorner()
  uint number;   // index of the triangle in the mesh
};
SH_FUNC uint clusterCorner(ClusterTriangle t, uint i) {
  return t.corners >> (10u * i) & 1023u;
}

struct MeshClusters {          // addresses of a mesh's clusters in device memory
  uint64_t clusters;           // Cluster[]
  uint64_t triangles;          // ClusterTriangle[]: kClusterTriangles per cluster
  uint64_t positions;          // VertexPosition[], cluster after cluster; 0 if the mesh deforms
  uint64_t vertices;           // uint[]: indices of the mesh's vertices; 0 if `positions` is set
  uint64_t clusterOfTriangle;  // uint[], by index of the triangle
};

// Backface cone culling: true if every triangle of a cluster faces away from a viewer. `direction` is the unit view
// direction: from the eye to `apex`, or the direction of an orthographic view. `margin` allows for rounding. (The cones
// are meshoptimizer's, after Shirman and Abi-Ezzi 1993, The Cone of Normals Technique for Fast Processing of Curved
// Patches, Computer Graphics Forum 12(3).)
SH_FUNC bool clusterFacesAway(vec3 direction, vec3 axis, float cutoff, float margin) {
  return dot(direction, axis) >= cutoff + margin;
}

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::Cluster) == 68);
static_assert(sizeof(latelight::shared::ClusterTriangle) == 8);
#endif

#endif
