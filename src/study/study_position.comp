#version 460
#extension GL_GOOGLE_include_directive : require
// The reconstruction of position from device depth, for `latelight study position`.
#include "study/evaluation.glsl"

layout(constant_id = kMethodConstant) const uint kMethod = 0;

// Input: xy are NDC, z is the device depth. Result: the view-space position.
vec4 evaluate(vec4 sampled) { return vec4(viewPosition(push.projection, kMethod, sampled.xy, sampled.z), 0.0); }
