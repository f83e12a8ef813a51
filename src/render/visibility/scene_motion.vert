#version 460
#extension GL_GOOGLE_include_directive : require
// Scene draws with clip positions of the previous and the next frame.
#define MOTION
#include "render/visibility/scene_vertex.glsl"
