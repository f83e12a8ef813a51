#version 460
#extension GL_GOOGLE_include_directive : require
// Counts the large triangles that touch each tile.
#define BIN(tile, triangle) atomicAdd(table.v[2u * (tile)], 1u)
#include "render/visibility/compute/raster_bin.glsl"
