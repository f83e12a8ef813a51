#version 460
// Copies words from one address to another.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require

layout(local_size_x = 64) in;
layout(buffer_reference, scalar) buffer Words { uint word[]; };
layout(push_constant, scalar) uniform Push {
  Words from, to;
  uint count;
} push;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < push.count) push.to.word[i] = push.from.word[i];
}
