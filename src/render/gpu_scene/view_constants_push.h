// Structs that view_constants.comp shares with the host (worlds.h).
#ifndef LATELIGHT_VIEW_CONSTANTS_PUSH_H
#define LATELIGHT_VIEW_CONSTANTS_PUSH_H

#include "shared/types.h"

SH_BEGIN

SH_CONST uint kConstantsGroup = 64u;  // invocations per workgroup

// The values of FrameConstants that a world may have instead of the scene or the settings.
struct WorldValues {
  uint lightCount, directionalLights, lightTreeLeaves, areaLightCount;
  float environmentIntensity, environmentCos, environmentSin;
  uint environmentMap;
};
SH_CONST uint kWorldHasLights = 1u;
SH_CONST uint kWorldHasIntensity = 2u;  // of the environment
SH_CONST uint kWorldHasRotation = 4u;   // of the environment
SH_CONST uint kWorldHasEnvironment = 8u;

// Everything about the views of one frame graph, which are consecutive views of a call: view v shows the world
// (firstView + v) / viewsPerWorld.
struct ViewConstants {
  FrameConstants frame;  // the constants of world 0
  uint64_t values;       // WorldValues[worlds], of which `has` states which are valid
  uint64_t exposures;    // float[views], or 0: all views have that of `frame`
  uint64_t result;       // FrameConstants[views]
  // Bytes from one world's elements to the next one's.
  uint64_t instanceStride, rasterStride, rayStride, lightStride, treeStride, areaStride, shadowStride, shadowBitsStride;
  uint views, firstView, viewsPerWorld;
  uint has;  // kWorldHas*
};

struct ViewConstantsPush {
  uint64_t constants;  // ViewConstants
};

SH_END

#endif
