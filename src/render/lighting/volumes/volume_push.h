// What a volume's shaders are pushed (volumes.cpp): one light, and no loads to get at it.
#ifndef LATELIGHT_VOLUME_PUSH_H
#define LATELIGHT_VOLUME_PUSH_H

#include "shared/types.h"

SH_BEGIN

struct VolumePush {
  uint64_t frame;     // FrameConstants
  uint64_t vertices;  // vec3[]: volume_mesh.h
  uint view;
  uint shape;    // kShape*
  float radius;  // of the mesh, metres: the light's, or of one without an end how far the scene goes
  LightShadow shadow;
  Light light;
};

SH_CONST uint kShapeScreen = 0u;  // one triangle over the whole picture, at depth 0: in front of nothing
SH_CONST uint kShapeSphere = 1u;
SH_CONST uint kShapeCone = 2u;

SH_END

#endif
