// Push constants of a volume's shaders (volumes.cpp): the light itself, so that it needs no loads.
#ifndef LATELIGHT_VOLUME_PUSH_H
#define LATELIGHT_VOLUME_PUSH_H

#include "shared/types.h"

SH_BEGIN

struct VolumePush {
  uint64_t frame;     // FrameConstants
  uint64_t vertices;  // vec3[]: volume_mesh.h
  uint view;
  uint shape;    // kShape*
  float radius;  // of the mesh, metres: the light's, or for one without a range the distance to the scene's end
  LightShadow shadow;
  Light light;
};

SH_CONST uint kShapeScreen = 0u;  // one triangle over the whole picture, at depth 0: behind everything
SH_CONST uint kShapeSphere = 1u;
SH_CONST uint kShapeCone = 2u;

SH_END

#endif
