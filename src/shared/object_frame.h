// The place of an instance in its object, for coordinates that stay with the surface: those of the scene at rest.
#ifndef LATELIGHT_SHARED_OBJECT_FRAME_H
#define LATELIGHT_SHARED_OBJECT_FRAME_H

#include "shared/lang.h"

SH_BEGIN

struct ObjectFrame {
  mat4x3 objectFromVertex;  // from the mesh's vertices on the device to the object's own frame, meters
  vec3 fromCenter;          // its translation, less the center of the object's box
  float inverseDiagonal;    // 1 / the length of the box's diagonal; 0 if the box has none
  uint64_t positions;       // VertexPosition[] of the mesh at rest
  uint64_t curvatures;      // vec2[] of its vertices: mean and Gaussian curvature; 0: not computed
};

SH_END

#endif
