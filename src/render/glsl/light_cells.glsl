// Cells of a picture: tiles of 16 by 16 pixels, cut into slices of depth. What light_lists.comp writes and the lighting
// shaders read.
//
// Slices are counted from the tile's nearest sample, so that a wall lies in one of them, and computed in integers from the
// stored depth: both passes must put a sample into the same slice, whatever their compilers make of a division. In a
// perspective view the key is the bits of B / y (y: view depth), which run like its logarithm: slices grow with
// distance. In an orthographic view it is linear in depth.
#ifndef LATELIGHT_LIGHT_CELLS_GLSL
#define LATELIGHT_LIGHT_CELLS_GLSL
#include "render/glsl/morton.glsl"

const uint kTileSize = 16u;
const uint kSlices = 32u;
const uint kOverflow = 0xffffffffu;  // a cell's count: its list did not fit

layout(constant_id = 16) const uint kCellsATile = 1;    // lists a tile: 1, or one a slice
layout(constant_id = 17) const uint kEntriesATile = 1;  // room for them

// A tile has kCellsATile + 1 elements: its slices (the key of its nearest sample, and bits a slice), then its cells
// (where the list starts among the tile's entries, and how many lights it has).
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer CellsRef { uvec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer EntriesRef { uint v[]; };  // indices of lights

// Nearer samples have larger keys.
uint depthKey(Projection p, float deviceDepth) {
  precise float linear = deviceDepth * 16777216.0;
  precise float inverse = abs(deviceDepth - p.A);
  return p.kind == kPerspective ? floatBitsToUint(inverse) : uint(linear);
}

uint sliceOf(uint key, uvec2 slices) { return min((slices.x - key) >> slices.y, kSlices - 1u); }

uint tileOf(uvec3 group, uvec2 tiles) { return (group.z * tiles.y + group.y) * tiles.x + group.x; }

#endif
