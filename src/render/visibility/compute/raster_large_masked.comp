#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// As raster_large.comp, for masked (alpha-tested) instances.
#include "render/visibility/compute/raster_tile.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/masked.glsl"
#include "render/visibility/compute/raster_large_pixels.glsl"
