#version 460
// The floats of pairs of halves.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#include "render/glsl/halves.glsl"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer ResultsRef { vec2 v[]; };
layout(push_constant, scalar) uniform Push {
  ResultsRef results;  // of the pairs 2 i and 2 i + 1
  uint count;
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < count) results.v[i] = floatsFromHalves(2u * i | (2u * i + 1u) << 16);
}
