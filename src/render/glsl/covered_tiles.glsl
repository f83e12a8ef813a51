// The tiles of pixels that surfaces cover (frame/covered_tiles.h), for passes that need no others.
#ifndef LATELIGHT_COVERED_TILES_GLSL
#define LATELIGHT_COVERED_TILES_GLSL
#include "render/base/pixel_group.h"
#include "render/frame/covered_tiles_push.h"

layout(constant_id = kCoveredTilesConstant) const uint kCoveredTiles = 0u;  // 1: a workgroup per covered tile

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CoveredTilesRef { CoveredTiles v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TileListRef { uint v[]; };

uint64_t tileList(uint64_t covered) { return covered + uint64_t(kCoveredTilesBytes); }

void appendTile(uint64_t covered, uvec3 tile) {
  CoveredTilesRef to = CoveredTilesRef(covered);
  uint index = atomicAdd(to.v.count, 1u);
  TileListRef(tileList(covered)).v[index] = tile.x | tile.y << kTileBits | tile.z << 2u * kTileBits;
  atomicMax(to.v.groups[0], min(index + 1u, kTilesAlong));
  atomicMax(to.v.groups[1], index / kTilesAlong + 1u);
}

// Returns the block of kPixelGroupX x kPixelGroupY pixels of this workgroup, and its view. A dispatch may have more
// workgroups than there are tiles; their block lies outside of every image.
uvec3 ownBlock(uint64_t covered) {
  if (kCoveredTiles == 0u) return gl_WorkGroupID;
  uint index = gl_WorkGroupID.y * kTilesAlong + gl_WorkGroupID.x;
  if (gl_WorkGroupID.y != 0u && index >= CoveredTilesRef(covered).v.count) return uvec3(kTileMask, kTileMask, 0u);
  uint tile = TileListRef(tileList(covered)).v[index];
  return uvec3(tile & kTileMask, tile >> kTileBits & kTileMask, tile >> 2u * kTileBits);
}

#endif
