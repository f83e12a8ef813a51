// hit(): stores a pixel that a triangle covers. The macro HIT_* of the shader's variant selects how
// (cmake/shaders.cmake); without one, opaque triangles are written to the visibility buffer. Include after raster.glsl.
#if defined(HIT_MASKED) || defined(HIT_LENS) || defined(HIT_LENS_BLENDED)
#include "render/visibility/compute/surface_point.glsl"
#endif

#if defined(HIT_MASKED)
#include "render/visibility/compute/masked.glsl"
#elif defined(HIT_LENS)
#include "render/visibility/compute/lens_visible.glsl"
#elif defined(HIT_LENS_BLENDED)
#include "render/visibility/compute/lens_blended.glsl"
#elif defined(HIT_BLENDED)
#include "render/visibility/compute/blended_hit.glsl"
#elif defined(HIT_OVERDRAW)
#include "render/visibility/compute/overdraw_hit.glsl"
#else
void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  writeSamples(view, pixel, samples, depth, id);
}
#endif
