#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// As raster.comp, for a picture through a lens: each ray that a triangle may meet is tried.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/lens_visible.glsl"
#include "render/visibility/compute/raster_groups.glsl"
