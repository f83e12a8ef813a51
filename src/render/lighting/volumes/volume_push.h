// Push constants of the shaders of light volumes (volumes.cpp). They contain the light itself, so shaders do not load
// it.
#ifndef LATELIGHT_VOLUME_PUSH_H
#define LATELIGHT_VOLUME_PUSH_H

#include "shared/types.h"

SH_BEGIN

struct VolumePush {
  uint64_t frame;     // FrameConstants
  uint64_t vertices;  // vec3[]: volume_mesh.h
  uint view;
  uint shape;    // kShape*
  float radius;  // of the mesh, meters: the light's, or, if unbounded, the distance to the scene's farthest point
  LightShadow shadow;
  Light light;
};

SH_CONST uint kShapeScreen = 0u;  // a full-screen triangle at depth 0, behind all surfaces
SH_CONST uint kShapeSphere = 1u;
SH_CONST uint kShapeCone = 2u;

SH_END

#endif
