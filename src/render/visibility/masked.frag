#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, textured
// Alpha test of masked materials for the depth pass.
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/fragment_point.glsl"

void main() {
#ifdef MULTISAMPLED
  gl_SampleMask[0] = -1;
#endif
  alphaTest(drawMaterial(), fragmentPoint());
}
