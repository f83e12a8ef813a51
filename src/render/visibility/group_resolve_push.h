// Push constants of group_resolve.comp and group_tiles.comp.
#ifndef LATELIGHT_GROUP_RESOLVE_PUSH_H
#define LATELIGHT_GROUP_RESOLVE_PUSH_H

#include "render/outputs/pack_push.h"

SH_BEGIN

SH_CONST uint kOnlyTextureGroup = 0xffffffffu;  // instead of a group: all materials are in one

struct GroupResolvePush {
  uint64_t frame;
  uint64_t covered;                 // CoveredTiles that show materials of the group
  OutputSlot slots[kPackedAtOnce];  // of the outputs that the pass packs
  uint group;
  uint padding;
};

struct GroupTilesPush {
  uint64_t frame;
  uint64_t covered;  // CoveredTiles
  uint64_t lists;    // one CoveredTiles per group
  uint64_t bytes;    // of each
};

SH_END

#endif
