// Maps each pixel of a lens camera's pinhole views to the rays of the image that it contains.
#ifndef LATELIGHT_LENS_PUSH_H
#define LATELIGHT_LENS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct LensTarget {
  uint64_t frame;   // FrameConstants of the image
  uint64_t starts;  // uint[views][height][width] and one more: per pinhole pixel, its first index in `pixels`
  uint64_t pixels;  // uint[]: the rays, as y * width + x of the image
  uint views;       // pinhole views per view of the image
  uint width;       // of the image
};

SH_END

#endif
