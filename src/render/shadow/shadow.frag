#version 460
#extension GL_GOOGLE_include_directive : require
// Writes a texel of a shadow map: depth, linear in meters, plus the caster's slope bias (shared/shadow.h). Before the
// division by w, the projection of a map produces z from 0 to 1/2 between near and far, and w is 1 (orthographic) or
// the distance divided by the far distance (perspective). Therefore z is gl_FragCoord.z times w in every kind of map,
// depth is twice that, and the shader loads no constants.
#include "render/glsl/common.glsl"
#define DRAW_PUSH ShadowDraw
#define NO_VARYINGS
#include "render/visibility/varyings.glsl"
#include "render/glsl/shadow_texel.glsl"

void main() { writeShadow(); }
