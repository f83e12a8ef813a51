#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured, coated
// Sorted transparency: outputs a shaded fragment for fixed-function blending with the over operator.
#include "render/glsl/common.glsl"
#include "render/transparency/blended.glsl"

layout(location = 0) out vec4 color;

void main() { color = blendedFragment(FrameRef(push.frame).v); }
