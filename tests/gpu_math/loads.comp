#version 460
// Compares each struct as its generated function loads it with the struct as the compiler loads it.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_GOOGLE_include_directive : require
#include "struct_headers.h"

#define STRUCT(type, members) \
  layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer type##Ref { type v; };
#include "structs.inc"
#undef STRUCT
const uint kTexelLoads = 1u;  // no struct is loaded member by member
#include "all_loads.glsl"

layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ResultsRef { uint v[]; };
layout(push_constant, scalar) uniform Push {
  uint64_t structs;  // random words
  ResultsRef results;
};

void main() {
  uint i = 0u;
#define LOAD(type) results.v[i++] = load##type(structs) == type##Ref(structs).v ? 1u : 0u;
#include "loads.inc"
}
