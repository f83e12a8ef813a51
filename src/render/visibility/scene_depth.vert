#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_VARYINGS
#include "render/visibility/scene_vertex.glsl"
