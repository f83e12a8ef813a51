// Runs of a mesh's triangles that are culled together.
#ifndef LATELIGHT_SHARED_CLUSTER_H
#define LATELIGHT_SHARED_CLUSTER_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kClusterTriangles = 128u;  // in the order of the indices

struct Cluster {  // 44 bytes; object space
  vec3 centre;    // of a sphere around it
  float radius;
  vec3 apex;      // of a cone of directions: see clusterFacesAway()
  float cutoff;   // 1: it faces all ways
  vec3 axis;
};

// Whether a cluster shows its back alone to whoever looks along `direction`, which has length 1: from the eye to its apex,
// or that of an orthographic view. `margin`: for rounding. (meshoptimizer's cones, after Shirman and Abi-Ezzi 1993, The
// Cone of Normals Technique for Fast Processing of Curved Patches, Computer Graphics Forum 12(3).)
SH_FUNC bool clusterFacesAway(vec3 direction, vec3 axis, float cutoff, float margin) {
  return dot(direction, axis) >= cutoff + margin;
}

SH_END

#endif
