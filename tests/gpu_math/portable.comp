#version 460
// Evaluates one portable function per row (y) for one set of arguments per column (x), in GLSL.
#extension GL_GOOGLE_include_directive : require
#include "shared/portable_cases.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Arguments { PortableArguments arguments[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Results { vec4 results[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint row = gl_GlobalInvocationID.y;
  results[row * gl_NumWorkGroups.x * 64u + i] = evaluatePortable(row, arguments[i]);
}
