// Stores a fragment where a blended triangle is not occluded along a lens ray. Include after raster.glsl and
// surface_point.glsl.
#include "render/visibility/compute/blended_fragment.glsl"
#include "render/visibility/compute/lens_rays.glsl"

void meets(FrameConstants frame, uint view, ivec2 pixel, float depth, uint id) {
  uvec2 size = uvec2(frameView(frame, view).size);
  uint place = pixelIndex(uvec3(pixel, view), size);
  if (visibleDepth(VisibleRef(push.buffers.visible).v[place]) <= depth) storeFragment(place, depth, id, 1u);
}
