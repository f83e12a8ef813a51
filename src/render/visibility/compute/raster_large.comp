#version 460
#extension GL_GOOGLE_include_directive : require
// variants: hits
// Software rasterization of large triangles per tile. Opaque triangles of a tile are merged in registers, all others
// store each pixel by itself.
#ifdef RASTER_HIT
#include "render/visibility/compute/raster_tile.glsl"
#include "render/visibility/compute/raster_hit.glsl"
#include "render/visibility/compute/raster_large_pixels.glsl"
#else
#extension GL_EXT_control_flow_attributes : require
#include "render/visibility/compute/raster_tile.glsl"
#include "render/visibility/compute/raster_large_tiles.glsl"
#endif
