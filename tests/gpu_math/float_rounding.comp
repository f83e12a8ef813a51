#version 460
// Rounds doubles to floats, and computes what the rounding removes.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "render/glsl/float_rounding.glsl"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer NumbersRef { double v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer ResultsRef { dvec3 v[]; };
layout(push_constant, scalar) uniform Push {
  NumbersRef numbers;
  ResultsRef results;  // rounded, widened, and the remainder
  uint count;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= count) return;
  double x = numbers.v[i];
  float rounded = float(x);
  results.v[i] = dvec3(roundedToFloat(x), widened(rounded), double(float(x - widened(rounded))));
}
