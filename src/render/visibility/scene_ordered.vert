#version 460
#extension GL_GOOGLE_include_directive : require
// Scene draws into fragment lists, with the instance's position in the draw order.
#define FRAGMENT_ORDER
#include "render/visibility/scene_vertex.glsl"
