#version 460
#extension GL_GOOGLE_include_directive : require
// variants: hits
// Software rasterization of small and medium triangles.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/raster_hit.glsl"
#include "render/visibility/compute/raster_groups.glsl"
