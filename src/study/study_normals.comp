#version 460
#extension GL_GOOGLE_include_directive : require
// The round trip of a normal through an encoding, for `latelight study normals`.
#include "study/evaluation.glsl"
#include "study/normal_round_trip.h"

layout(constant_id = kEncodingConstant) const uint kEncoding = 0;
layout(constant_id = kBitsConstant) const uint kBits = 8;

vec4 evaluate(vec4 sampled) { return vec4(normalRoundTrip(kEncoding, kBits, sampled.xyz), 0.0); }
