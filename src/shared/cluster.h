// Clusters: 128 triangles of a mesh that lie together, with the vertices they share. They are culled as one, and a
// workgroup rasterizes one.
#ifndef LATELIGHT_SHARED_CLUSTER_H
#define LATELIGHT_SHARED_CLUSTER_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kClusterTriangles = 128u;  // all but a mesh's last have as many
SH_CONST uint kClusterVertices = 384u;   // at most: of triangles that share none

struct Cluster {  // 68 bytes; object space
  vec3 centre;    // of a sphere and a box around it
  float radius;
  vec3 extent;   // of the box: half its sides
  float edge;    // the longest of its triangles
  vec3 apex;     // of a cone of directions: see clusterFacesAway()
  float cutoff;  // 1: it faces all ways
  vec3 axis;
  uint firstVertex;  // of MeshClusters::positions or vertices
  uint vertices;
};

struct ClusterTriangle {
  uint corners;  // clusterCorner(): which of the cluster's vertices
  uint number;   // of the mesh
};
SH_FUNC uint clusterCorner(ClusterTriangle t, uint i) {
  return t.corners >> (10u * i) & 1023u;
}

struct MeshClusters {          // where they lie in device memory
  uint64_t clusters;           // Cluster[]
  uint64_t triangles;          // ClusterTriangle[]: kClusterTriangles a cluster
  uint64_t positions;          // VertexPosition[], cluster after cluster; 0: the mesh is deformed
  uint64_t vertices;           // uint[]: which of the mesh's; 0: positions are known
  uint64_t clusterOfTriangle;  // uint[], by its number
};

// Whether a cluster shows its back alone to whoever looks along `direction`, which has length 1: from the eye to its
// apex, or that of an orthographic view. `margin`: for rounding. (meshoptimizer's cones, after Shirman and Abi-Ezzi
// 1993, The Cone of Normals Technique for Fast Processing of Curved Patches, Computer Graphics Forum 12(3).)
SH_FUNC bool clusterFacesAway(vec3 direction, vec3 axis, float cutoff, float margin) {
  return dot(direction, axis) >= cutoff + margin;
}

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::Cluster) == 68);
static_assert(sizeof(latelight::shared::ClusterTriangle) == 8);
#endif

#endif
