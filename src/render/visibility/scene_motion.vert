#version 460
#extension GL_GOOGLE_include_directive : require
#define MOTION
#include "render/glsl/scene_vertex.glsl"
