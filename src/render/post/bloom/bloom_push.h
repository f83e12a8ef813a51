// Push constants of the bloom passes.
#ifndef LATELIGHT_RENDER_POST_BLOOM_PUSH_H
#define LATELIGHT_RENDER_POST_BLOOM_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct BloomDownPush {
  float scale;  // factor for the source
  float threshold;
};

struct BloomUpPush {
  float radius;
};

struct BloomBlendPush {
  float scale;  // factor for the picture
  float threshold;
  float strength;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::BloomDownPush) == 8);
static_assert(sizeof(latelight::shared::BloomUpPush) == 4);
static_assert(sizeof(latelight::shared::BloomBlendPush) == 12);
#endif

#endif
