#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// As raster.comp, for images through a lens: tests each ray that a triangle may meet.
#include "render/visibility/compute/raster.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/visibility/compute/lens_visible.glsl"
#include "render/visibility/compute/raster_groups.glsl"
