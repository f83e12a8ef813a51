#version 460
#extension GL_GOOGLE_include_directive : require
// A shadow map's texel: depth, linear in metres, and the caster's slope bias (shared/shadow.h). A map's projection
// leaves z from 0 to 1/2 between near and far before the division by w, and w is 1 or distance over the farthest: so z is
// gl_FragCoord.z times w, whatever the kind of map, and nothing has to be loaded. Twice that is depth.
#include "render/glsl/common.glsl"
#define DRAW_PUSH ShadowDraw
#define NO_VARYINGS
#include "render/visibility/varyings.glsl"
#include "render/glsl/shadow_texel.glsl"

void main() { writeShadow(); }
