#version 460
#extension GL_GOOGLE_include_directive : require
// Software rasterization of blended instances into fragments: small and medium triangles.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/blended_hit.glsl"
#include "render/visibility/compute/raster_groups.glsl"
