// Cells of tiled and clustered light culling: tiles of 16x16 pixels, which clustered culling divides into depth slices
// (Olsson, Billeter and Assarsson 2012, Clustered Deferred and Forward Shading, HPG). light_lists.comp writes them; the
// lighting shaders read them.
//
// Slices are counted from the tile's nearest sample, so that a wall lies in one slice. They are computed in integers
// from the stored depth, because both passes must assign a sample to the same slice even if their compilers round
// divisions differently. In a perspective view the key is the bits of B / y (y: view depth), which are approximately
// logarithmic, so slices grow with distance. In an orthographic view the key is linear in depth.
#ifndef LATELIGHT_LIGHT_CELLS_GLSL
#define LATELIGHT_LIGHT_CELLS_GLSL
#include "render/glsl/morton.glsl"

const uint kTileSize = 16u;
const uint kSlices = 32u;
const uint kOverflow = 0xffffffffu;  // count of a cell whose list did not fit

layout(constant_id = kCellsPerTileConstant) const uint kCellsPerTile = 1;    // lists per tile: 1, or one per slice
layout(constant_id = kEntriesPerTileConstant) const uint kEntriesPerTile = 1;  // capacity for entries per tile

// A tile has kCellsPerTile + 1 elements: its slices (key of its nearest sample, bits per slice), then its cells (first
// entry within the tile's entries, number of lights).
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer CellsRef { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer EntriesRef { uint v[]; };  // light indices

// Nearer samples have larger keys.
uint depthKey(Projection p, float deviceDepth) {
  precise float linear = deviceDepth * 16777216.0;
  precise float inverse = abs(deviceDepth - p.A);
  return p.kind == kPerspective ? floatBitsToUint(inverse) : uint(linear);
}

uint sliceOf(uint key, uvec2 slices) { return min((slices.x - key) >> slices.y, kSlices - 1u); }

uint tileOf(uvec3 group, uvec2 tiles) { return (group.z * tiles.y + group.y) * tiles.x + group.x; }

#endif
