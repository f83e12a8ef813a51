// The sources of data outputs in images of the geometry pass (hardware raster): words of the layout `exact`, four per
// image. Word 4 t + c is channel c of target t.
#ifndef LATELIGHT_RENDER_OUTPUTS_DATA_WORDS_H
#define LATELIGHT_RENDER_OUTPUTS_DATA_WORDS_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kMaxDataImages = 6u;  // with a layout of one target; light is the eighth color attachment
SH_CONST uint kNoDataWord = 255u;
SH_CONST uint kNoDataWords = 0xffffffffu;  // an image's four words, the first in the lowest byte

SH_END

#endif
