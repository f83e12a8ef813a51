#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured, coated
// Weighted blended OIT, first pass: outputs a shaded fragment to two order-independent sums (McGuire and Bavoil 2013,
// Weighted Blended Order-Independent Transparency, JCGT 2(2)).
#include "render/glsl/common.glsl"
#include "render/transparency/blended.glsl"
#include "render/transparency/weight.glsl"

layout(location = 0) out vec4 colors;   // rgb: the sum of premultiplied radiance times weight; a: coverage
layout(location = 1) out float weights;  // the sum of alpha times weight

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  vec4 color = blendedFragment(frame);
  float weight = weightAt(viewDepth(frameView(frame, push.view).projection, gl_FragCoord.z), color.a);
  colors = vec4(color.rgb * weight, color.a);
  weights = color.a * weight;
}
