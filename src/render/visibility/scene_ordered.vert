#version 460
#extension GL_GOOGLE_include_directive : require
#define FRAGMENT_ORDER
#include "render/visibility/scene_vertex.glsl"
