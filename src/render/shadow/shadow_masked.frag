#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// As shadow.frag, for alpha-masked materials.
#include "render/glsl/common.glsl"
#define DRAW_PUSH ShadowDraw
#include "render/visibility/varyings.glsl"
#include "render/visibility/fragment_point.glsl"
#include "render/glsl/shadow_texel.glsl"

void main() {
  writeShadow();
  if (masked(drawMaterial(), fragmentPoint())) discard;
}
