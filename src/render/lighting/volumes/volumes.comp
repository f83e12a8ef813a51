#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, multisampled
// Light volumes, last pass: computes the lit picture from the G-buffer (emitted radiance and environment) and lightSum,
// the sum of the lights that the volumes added.
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/lighting/lighting_push.h"

layout(set = 0, binding = AFTER_LIT_MAPS) uniform TARGET_SAMPLER lightSum;

layout(push_constant, scalar) uniform Push { LightingPush push; };

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) {
#ifdef MULTISAMPLED
  // The samples of a surface have the same light, except where the rim of a volume separates them. Samples inside the
  // volume have all of its light, so the maximum is correct.
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; ++i)
    if ((p.samples >> i & 1u) != 0u) sum = max(sum, texelFetch(lightSum, p.place, i).rgb);
  return sum;
#else
  return p.lit ? texelFetch(lightSum, p.place, 0).rgb : vec3(0.0);
#endif
}

void main() { lightPixel(uniformFrame(push.frame, gl_WorkGroupID.z), ownPixel()); }
