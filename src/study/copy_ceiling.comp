#version 460
#extension GL_GOOGLE_include_directive : require
// Measures the copy bandwidth: copies one buffer to another, 16 bytes at a time.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "study/ceilings_push.h"

layout(local_size_x = 256) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer SourceRef { uvec4 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer TargetRef { uvec4 v[]; };
layout(push_constant, scalar) uniform Push { CopyPush push; };

void main() {
  uint first = gl_WorkGroupID.x * gl_WorkGroupSize.x * kCopyChunk + gl_LocalInvocationIndex;
  uvec4 values[kCopyChunk];
  for (uint i = 0u; i < kCopyChunk; ++i) values[i] = SourceRef(push.source).v[first + i * gl_WorkGroupSize.x];
  for (uint i = 0u; i < kCopyChunk; ++i) TargetRef(push.target).v[first + i * gl_WorkGroupSize.x] = values[i];
}
