#version 460
#extension GL_GOOGLE_include_directive : require
// Scene draws of opaque surfaces that find the visible triangles: positions, and the instance.
#define NO_VARYINGS
#define INSTANCE_VARYING
#include "render/visibility/scene_vertex.glsl"
