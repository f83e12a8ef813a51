#version 460
#extension GL_GOOGLE_include_directive : require
#define MOTION
#include "render/visibility/scene_vertex.glsl"
