#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/visibility/scene_vertex.glsl"
