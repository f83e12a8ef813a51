#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible, multisampled, sample-layers
// interlaced: every second row of the picture, every light at every pixel of them.
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/lighting/interlaced/interlaced_push.h"

layout(push_constant, scalar) uniform Push { FieldPush push; };

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) {
  return shadeAllLights(frame, uint(p.place.z), p.s, surfaceBrdf(p.s, p.toEye, kShading), p.lit);
}

void main() {
  bindSurfaces(push.frame, push.shown);
  ivec3 place = ownPixel();
  place.y = 2 * place.y + int(push.firstRow);
  bool lit = lightPixel(FrameRef(push.frame).v, place);
  writeCounts(place, lit, lightCount());
}
