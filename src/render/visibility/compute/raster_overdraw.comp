#version 460
#extension GL_GOOGLE_include_directive : require
// As raster.comp, but counts the triangles per pixel.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/overdraw_hit.glsl"
#include "render/visibility/compute/raster_groups.glsl"
