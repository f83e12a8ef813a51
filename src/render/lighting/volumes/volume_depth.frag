#version 460
// Copies depth to where there is stencil beside it.
layout(set = 0, binding = 0) uniform sampler2DArray depthSource;
layout(push_constant) uniform Push { layout(offset = 16) uint view; };  // as volume_push.glsl has it

void main() { gl_FragDepth = texelFetch(depthSource, ivec3(ivec2(gl_FragCoord.xy), int(view)), 0).r; }
