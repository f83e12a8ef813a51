#version 460
#extension GL_GOOGLE_include_directive : require
// Triangles of blended instances.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/blended_hit.glsl"
#include "render/visibility/compute/raster_groups.glsl"
