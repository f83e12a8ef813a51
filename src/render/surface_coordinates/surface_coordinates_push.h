// Push constants of surface_coordinates.comp.
#ifndef LATELIGHT_RENDER_SURFACE_COORDINATES_PUSH_H
#define LATELIGHT_RENDER_SURFACE_COORDINATES_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct SurfaceCoordinatesPush {
  uint64_t frame;         // FrameConstants
  uint64_t objectFrames;  // ObjectFrame[] of all instances; 0 for coordinates that do not depend on it
  uint coordinate;        // kCoordinate*
};

SH_CONST uint kCoordinateObject = 0u;  // position in the object's own frame
SH_CONST uint kCoordinateNocs = 1u;
SH_CONST uint kCoordinateBarycentric = 2u;
SH_CONST uint kCoordinateTangent = 3u;  // world space
SH_CONST uint kCoordinateBitangent = 4u;
SH_CONST uint kCoordinateFlow = 5u;       // to the next frame; world space
SH_CONST uint kCoordinateCurvature = 6u;  // mean and Gaussian

SH_END

#endif
