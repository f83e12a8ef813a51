#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible, multisampled, sample-layers
// Deferred shading without light culling: reads the G-buffer and shades every pixel with every light. Output: the lit
// picture in lightTarget, and the numbers of lights tested and used in lightCounts.
#include "render/glsl/common.glsl"
#include "render/glsl/covered_tiles.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/lighting/lighting_push.h"

layout(push_constant, scalar) uniform Push { LightingPush push; };

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) {
  return shadeAllLights(frame, uint(p.place.z), p.s, surfaceBrdf(p.s, p.toEye, kShading), p.lit);
}

void main() {
  bindSurfaces(push.frame, push.shown);
  uvec3 block = ownBlock(push.covered);
  ivec3 place = pixelOf(block);
  bool lit = lightPixel(uniformFrame(push.frame, block.z), place);
  writeCounts(place, lit, lightCount());
}
