#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured, coated
// sorted: outputs a blended fragment for fixed-function blending.
#include "render/glsl/common.glsl"
#include "render/transparency/blended.glsl"

layout(location = 0) out vec4 color;

void main() { color = blendedFragment(FrameRef(push.frame).v); }
