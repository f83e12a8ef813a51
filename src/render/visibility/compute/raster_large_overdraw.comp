#version 460
#extension GL_GOOGLE_include_directive : require
// As raster_large.comp, but counts the triangles per pixel.
#include "render/visibility/compute/raster_tile.glsl"
#include "render/visibility/compute/overdraw_hit.glsl"
#include "render/visibility/compute/raster_large_pixels.glsl"
