#version 460
#extension GL_GOOGLE_include_directive : require
// Light volumes with several samples per pixel: discards all pixels except those with several surfaces, so that the
// draw marks these in stencil.
#define MULTISAMPLED
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/lighting/volumes/volume_push.h"
layout(set = 0, binding = 0) uniform usampler2DArray pixelSurfaces;
layout(push_constant, scalar) uniform Push { VolumePush push; };

void main() {
  if (countSurfaces(pixelSurfaces, ivec3(ivec2(gl_FragCoord.xy), int(push.view))).x < 2u) discard;
}
