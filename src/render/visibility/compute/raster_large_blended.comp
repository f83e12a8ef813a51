#version 460
#extension GL_GOOGLE_include_directive : require
// As raster_large.comp, for blended instances.
#include "render/visibility/compute/raster_tile.glsl"
#include "render/visibility/compute/blended_hit.glsl"
#include "render/visibility/compute/raster_large_pixels.glsl"
