// Writes the surfaces of multisampled pixels (shared/samples.h), and the depth at the center of each, at which it is
// lit. The including shader defines what one surface is (nextSurface()) and the first image binding (SURFACES_BINDING).
#include "render/visibility/compute/raster_push.h"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/compute/pixel_triangles.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = SURFACES_BINDING, r32f) uniform writeonly image2DArray depthTarget;
layout(set = 0, binding = 1 + SURFACES_BINDING, r32ui) uniform writeonly uimage2DArray surfacesTarget;

layout(push_constant, scalar) uniform Push { ResolvePush push; };

// Returns the samples of the next surface and removes them from `left`, which must not be empty.
uint nextSurface(View view, ivec3 pixel, uint first, inout uint left);

float meanDepth(uint first, uint samples) {
  VisibleRef visible = VisibleRef(push.visible);
  precise float sum = 0.0;
  for (uint i = 0u; i < kSamples; ++i)
    sum += hasSample(samples, i) ? visibleDepth(visible.v[first + i]) : 0.0;
  precise float mean = sum / float(bitCount(samples));
  return mean;
}

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(FrameRef(push.frame).v, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  uint first = visibleIndex(uvec3(pixel), uvec2(view.size));
  uint left = coveredSamples(VisibleRef(push.visible), first);
  for (uint layer = 0u; layer < surfaceLayers(kSamples); ++layer) {
    uint some = 0u;
    for (uint i = 0u; i < surfacesPerLayer(kSamples) && left != 0u; ++i) {
      uint surface = nextSurface(view, pixel, first, left);
      imageStore(depthTarget, sampleLayer(pixel, uint(findLSB(surface))), vec4(meanDepth(first, surface)));
      some |= surface << (kSamples * i);
    }
    imageStore(surfacesTarget, ivec3(pixel.xy, pixel.z * int(surfaceLayers(kSamples)) + int(layer)), uvec4(some));
  }
}
