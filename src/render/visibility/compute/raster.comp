#version 460
#extension GL_GOOGLE_include_directive : require
// Software rasterization of opaque instances into the visibility buffer: small and medium triangles.
#include "render/visibility/compute/raster.glsl"

void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  writeSamples(view, pixel, samples, depth, id);
}
#include "render/visibility/compute/raster_groups.glsl"
