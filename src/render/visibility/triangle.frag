#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// The visible triangles: the number of the instance, from 1, and the index of the triangle in its mesh.
#include "render/glsl/common.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/fragment_point.glsl"

layout(constant_id = kAlphaMaskedConstant) const uint kAlphaMasked = 0;

layout(location = 0) out uvec2 triangle;

void main() {
  triangle = uvec2(varyingInstance + 1u,
                   (push.firstTriangle + uint(gl_PrimitiveID)) / (kVastDraw != 0u ? kVastFan : 1u));
  // Last, as in geometry.frag, because textures need the whole quad.
  if (kAlphaMasked != 0u && masked(drawMaterial(), fragmentPoint())) discard;
}
