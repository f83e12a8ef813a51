#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of alpha-masked materials.
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/glsl/varyings.glsl"
#include "render/glsl/material.glsl"

void main() {
#ifdef MULTISAMPLED
  gl_SampleMask[0] = -1;
#endif
  cutFragment(drawMaterial());
}
