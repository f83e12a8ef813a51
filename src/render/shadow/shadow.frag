#version 460
#extension GL_GOOGLE_include_directive : require
// A shadow map's texel: depth, linear in metres, and the caster's slope bias (shared/shadow.h). Before the division by
// w a map's projection gives z from 0 to 1/2 between near and far, and w is 1 or the distance over the farthest one: so
// z is gl_FragCoord.z times w in every kind of map, and no constants have to be loaded. Depth is twice that.
#include "render/glsl/common.glsl"
#define DRAW_PUSH ShadowDraw
#define NO_VARYINGS
#include "render/visibility/varyings.glsl"
#include "render/glsl/shadow_texel.glsl"

void main() { writeShadow(); }
