#version 460
#extension GL_GOOGLE_include_directive : require
// The visible triangles of opaque surfaces, as triangle.frag writes them, without its varyings.
#define NO_VARYINGS
#define INSTANCE_VARYING
#include "render/glsl/common.glsl"
#include "render/visibility/varyings.glsl"

layout(location = 0) out uvec2 triangle;

void main() { triangle = uvec2(varyingInstance + 1u, push.firstTriangle + uint(gl_PrimitiveID)); }
