#version 460
#extension GL_GOOGLE_include_directive : require
// shadow.frag for alpha-masked materials.
#include "render/glsl/common.glsl"
#define DRAW_PUSH_SHADOW
#include "render/glsl/varyings.glsl"
#include "render/glsl/material.glsl"
#include "render/glsl/shadow_texel.glsl"

void main() {
  writeShadow();
  if (cutOut(drawMaterial())) discard;
}
