#version 460
#extension GL_GOOGLE_include_directive : require
// Scene draws with all attributes.
#include "render/visibility/scene_vertex.glsl"
