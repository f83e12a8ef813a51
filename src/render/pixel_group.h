// How many pixels the workgroups of heavy shaders have, those that evaluate materials or light surfaces. The registers of
// all invocations of a workgroup have to be free before it begins: with 256 of them an H200 took a tenth longer for
// materials, and a quarter for the light of several samples. With 64 it begins so many that small views take longer.
#ifndef LATELIGHT_PIXEL_GROUP_H
#define LATELIGHT_PIXEL_GROUP_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kPixelGroupX = 16u, kPixelGroupY = 8u;

SH_END

#endif
