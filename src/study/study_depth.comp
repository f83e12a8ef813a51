#version 460
#extension GL_GOOGLE_include_directive : require
// The round trip of a device depth through a format, for `latelight study depth`.
#include "study/depth_formats.h"
#include "study/evaluation.glsl"

layout(constant_id = kFormatConstant) const uint kFormat = 0;

// Input: x is the device depth. Result: x is the stored depth, y the view depth.
vec4 evaluate(vec4 sampled) {
  float stored = storedDepth(kFormat, sampled.x);
  return vec4(stored, viewDepth(push.projection, stored), 0.0, 0.0);
}
