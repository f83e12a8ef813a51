#version 460
// Evaluates one shared function per row (y) for one set of arguments per column (x).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "shared/function_cases.h"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ArgumentsRef { Arguments v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ResultsRef { vec4 v[]; };
layout(push_constant, scalar) uniform Push {
  ArgumentsRef arguments;
  ResultsRef results;
  uint count;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  results.v[gl_GlobalInvocationID.y * count + i] = evaluateFunction(gl_GlobalInvocationID.y, arguments.v[i]);
}
