#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// As raster_lens_blended.comp, for large triangles.
#include "render/visibility/compute/raster_tile.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/lens_blended.glsl"
#include "render/visibility/compute/raster_large_pixels.glsl"
