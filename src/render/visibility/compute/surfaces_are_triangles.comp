#version 460
#extension GL_GOOGLE_include_directive : require
// The surfaces of multisampled pixels without a G-buffer: each triangle is one surface.
#define MULTISAMPLED
#define SAMPLE_LAYERS
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/glsl/setup.glsl"
#define SURFACES_BINDING 0
#include "render/visibility/compute/pixel_surfaces.glsl"

uint nextSurface(View view, ivec3 pixel, uint first, inout uint left) {
  return nextTriangle(VisibleRef(push.visible), first, left);
}
