// Keeps the nearest surface along each lens ray. Include after raster.glsl and surface_point.glsl.
#include "render/visibility/compute/lens_rays.glsl"

void meets(FrameConstants frame, uint view, ivec2 pixel, float depth, uint id) {
  uvec2 size = uvec2(frameView(frame, view).size);
  writeVisible(visibleIndex(uvec3(pixel, view), size), visibleValue(depth, id));
}
