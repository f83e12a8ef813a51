#version 460
#extension GL_GOOGLE_include_directive : require
// Depth resolve: if a pixel's samples lie in a plane, its depth at the pixel's center, which is their mean; otherwise
// the depth of the first covered sample, because a mean would lie between two surfaces.
#define MULTISAMPLED
#include "render/glsl/multisample.glsl"
layout(set = 0, binding = 0) uniform sampler2DMSArray sampleDepth;
layout(push_constant) uniform Push { uint view; };

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(view));
  vec4 d;
  for (int i = 0; i < 4; ++i) d[i] = texelFetch(sampleDepth, pixel, i).r;
  float least = min(min(d.x, d.y), min(d.z, d.w)), most = max(max(d.x, d.y), max(d.z, d.w));
  // The midpoint of samples 0 and 3 is that of samples 1 and 2.
  bool plane = least > 0.0 && abs((d.x + d.w) - (d.y + d.z)) <= 0.05 * (most - least) + 1e-6 * most;
  float first = d.x != 0.0 ? d.x : d.y != 0.0 ? d.y : d.z != 0.0 ? d.z : d.w;
  gl_FragDepth = plane ? depthOfSamples(sampleDepth, pixel, 15u) : first;
}
