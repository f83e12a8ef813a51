// Parameters of cast.comp: rays, and what they hit.
#ifndef LATELIGHT_RENDER_RAYS_CAST_PUSH_H
#define LATELIGHT_RENDER_RAYS_CAST_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct CastPush {
  uint64_t frame;                // FrameConstants; with worlds, of the first one
  uint64_t origins, directions;  // float or double[count][3]; with worlds, world by world
  uint64_t numbers;              // double[7]: origin of the device's world space, origin of positions, maximum distance
  // Results, one value per ray; 0: not needed.
  uint64_t distance;                      // float
  uint64_t position, normal, geonormal;   // float[3]
  uint64_t uv;                            // float[2]
  uint64_t id, part, material, triangle;  // uint
  uint64_t intensity;                     // float
  uint count;
  uint flags;          // kRayAnySurface (shared/rays.h) and kCast...
  uint perWorld;       // rays per world; without worlds, at least `count`
  uint instanceCount;  // of a world
};
SH_CONST uint kCastFileAxes = 0x100u;  // the frame of the rays is glTF's
SH_CONST uint kCastDoubles = 0x200u;   // elements of origins and directions

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::CastPush) == 128);  // the limit of all Vulkan devices
#endif

#endif
