#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// Rasterization of blended instances for images through a lens.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/lens_blended.glsl"
#include "render/visibility/compute/raster_groups.glsl"
