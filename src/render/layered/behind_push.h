// Push constants of behind.comp, and the arrangement of the levels of the transmission background.
#ifndef LATELIGHT_BEHIND_PUSH_H
#define LATELIGHT_BEHIND_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct BackgroundMipPush {
  uint level;  // level to write; 0: a copy of the picture
};

// All levels are in one image: the picture, and to its right the others from top to bottom, each half the size of the
// previous one, with an empty row between them. Each side of a level has at least one texel.
SH_FUNC uvec2 backgroundMipSize(uvec2 size, uint level) {
  return uvec2(max(size.x >> level, 1u), max(size.y >> level, 1u));
}
SH_FUNC uvec2 backgroundMipCorner(uvec2 size, uint level) {
  if (level == 0u) return uvec2(0u, 0u);
  return uvec2(size.x, size.y - (size.y >> (level - 1u)) + level);
}
// The number of levels, down to a single texel.
SH_FUNC uint backgroundMips(uvec2 size) {
  return 1u + uint(log2(float(max(size.x, size.y)) + 0.5f));
}

SH_END

#endif
