#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, multisampled, textured
// The geometry pass (geometry.glsl).
#define DRAW_NUMBERS
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#include "render/glsl/gbuffer_write.glsl"
#include "render/visibility/geometry.glsl"
