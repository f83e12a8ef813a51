// The main function of every study's shader: each invocation maps one vec4 of `inputs` to one of `outputs`. The shader
// that includes this file defines evaluate().
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#include "constant_ids.glsl"
#include "study/evaluation_push.h"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer InputsRef { vec4 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer OutputsRef { vec4 v[]; };
layout(push_constant, scalar) uniform Push { EvaluationPush push; };

vec4 evaluate(vec4 sampled);

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < push.count) OutputsRef(push.outputs).v[i] = evaluate(InputsRef(push.inputs).v[i]);
}
