#version 460
#extension GL_GOOGLE_include_directive : require
// Copies depth that compute shaders wrote into a depth attachment, for depth tests.
layout(push_constant) uniform Push { uint view; };
layout(set = 0, binding = 0) uniform sampler2DArray depths;

void main() { gl_FragDepth = texelFetch(depths, ivec3(gl_FragCoord.xy, view), 0).r; }
