// Push constants of paths.comp.
#ifndef LATELIGHT_RENDER_LIGHTING_REFERENCE_PATHS_PUSH_H
#define LATELIGHT_RENDER_LIGHTING_REFERENCE_PATHS_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

// The specialization constant kPathsFromLightsConstant.
SH_CONST uint kPathsFromLights = 1u;       // paths find the lights' light on visible surfaces
SH_CONST uint kPathsFromEye = 2u;          // where coats or translucent surfaces are visible, paths start at the eye
SH_CONST uint kPathsFindTranslucent = 4u;  // rays find blended and transmissive surfaces

struct PathsPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  uint64_t emitterSums;  // float[emitterStride]: running sums of the emitters' powers; with worlds, for each view
  uint64_t lightSizes;   // float[lightCount], as RayShadow::lightSize; with lights of worlds, for each view
  uint first, end;       // samples of this pass
  uint samples;          // of all passes
  uint firstPoint;       // index of the first sample's point in the pixels' sequences
  uint bounces;          // maximum number of surfaces after the visible one
  uint emitterStride, lightStride;  // elements from one view to the next
  uint padding;
};

SH_END

#endif
