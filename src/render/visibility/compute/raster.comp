#version 460
#extension GL_GOOGLE_include_directive : require
// Triangles of opaque instances.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/raster_groups.glsl"
