// Which rays of a picture through a lens each pixel of its pinhole views has.
#ifndef LATELIGHT_LENS_PUSH_H
#define LATELIGHT_LENS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct LensTarget {
  uint64_t frame;   // FrameConstants of the picture
  uint64_t starts;  // uint[views][height][width] and one more, of the pinhole views of a view: where their rays begin
  uint64_t pixels;  // uint[]: the rays, as y * width + x of the picture
  uint views;       // pinhole views of a view
  uint width;       // of the picture
};

SH_END

#endif
