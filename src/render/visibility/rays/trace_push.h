// Parameters of trace_visible.comp.
#ifndef LATELIGHT_RENDER_VISIBILITY_RAYS_TRACE_PUSH_H
#define LATELIGHT_RENDER_VISIBILITY_RAYS_TRACE_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct TraceVisiblePush {
  uint64_t frame;           // FrameConstants
  uint64_t firstTriangles;  // uint[]: RasterInstance::firstTriangle, by index in FrameConstants::instances
  uint64_t visible;         // as in RasterBuffers
  uint surfaces;            // kRayAnySurface, or 0: opaque and masked surfaces only
  uint padding;
};

SH_END

#endif
