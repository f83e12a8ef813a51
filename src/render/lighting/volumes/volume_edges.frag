#version 460
#extension GL_GOOGLE_include_directive : require
// Leaves the pixels with several surfaces, for stencil to mark.
#define MULTISAMPLED
#include "render/glsl/multisample.glsl"
layout(set = 0, binding = 0) uniform usampler2DArray pixelSurfaces;
layout(push_constant) uniform Push { layout(offset = 16) uint view; };  // as volume_push.glsl has it

void main() {
  if (surfaceCount(texelFetch(pixelSurfaces, ivec3(ivec2(gl_FragCoord.xy), int(view)), 0).r) < 2u) discard;
}
