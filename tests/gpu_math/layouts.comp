#version 460
// Copies one value of every shared struct, so that the SPIR-V contains its layout. It is never run.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_GOOGLE_include_directive : require
#include "struct_headers.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { uint64_t address; };

#define STRUCT(type, members) \
  layout(buffer_reference, scalar, buffer_reference_align = 8) buffer type##Array { type v[]; };
#include "structs.inc"
#undef STRUCT

void main() {
#define STRUCT(type, members) type##Array(address).v[0] = type##Array(address).v[1];
#include "structs.inc"
}
