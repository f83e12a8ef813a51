#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// Software rasterization of masked (alpha-tested) instances: small and medium triangles.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/masked.glsl"
#include "render/visibility/compute/raster_groups.glsl"
