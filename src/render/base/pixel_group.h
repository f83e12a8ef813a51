// The workgroup size, in pixels, of heavy shaders, which evaluate materials or light surfaces. A workgroup starts only
// when the registers for all its invocations are free. On an H200, workgroups of 256 invocations are therefore slower
// for materials and, even more so, for lighting several samples. With 64 invocations, the number of workgroups makes
// small views slower. Only paths have several of these blocks per workgroup (blocksOfPaths() in reference.cpp).
#ifndef LATELIGHT_PIXEL_GROUP_H
#define LATELIGHT_PIXEL_GROUP_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kPixelGroupX = 16u, kPixelGroupY = 8u;

SH_END

#endif
