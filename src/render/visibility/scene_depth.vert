#version 460
#extension GL_GOOGLE_include_directive : require
// Scene draws of the depth pass and of shadow maps: positions only.
#define NO_VARYINGS
#include "render/visibility/scene_vertex.glsl"
