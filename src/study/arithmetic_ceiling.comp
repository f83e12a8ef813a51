#version 460
#extension GL_GOOGLE_include_directive : require
// Measures the arithmetic ceiling with multiply-adds in registers. Each depends on the previous one in its chain, and
// the last results are stored, so that the compiler cannot remove any.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "study/ceilings_push.h"

layout(local_size_x = 256) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ResultsRef { float v[]; };
layout(push_constant, scalar) uniform Push { ArithmeticPush push; };

void main() {
  vec4 a = vec4(0.0, 0.25, 0.5, 0.75) + float(gl_LocalInvocationIndex), b = a * 0.5;  // kArithmeticChains in all
  vec4 factor = vec4(push.factor), summand = vec4(push.summand);
  for (uint round = 0u; round < push.rounds; ++round) {
    for (uint step = 0u; step < kArithmeticSteps; ++step) {
      a = fma(a, factor, summand);
      b = fma(b, factor, summand);
    }
  }
  ResultsRef(push.results).v[gl_GlobalInvocationID.x] = dot(a + b, vec4(1.0));
}
