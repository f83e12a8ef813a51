#version 460
#extension GL_GOOGLE_include_directive : require
// The surfaces of pixels of several samples where there is no G-buffer to compare them by: each triangle is one.
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
