#version 460
#extension GL_GOOGLE_include_directive : require
// FXAA, first pass: computes the finished picture before it is rounded to 8 bits, as linear display color with straight
// alpha.
#include "render/post/compose.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray picture;  // linear, premultiplied by alpha
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2DArray display;
layout(push_constant, scalar) uniform Push { ComposePush push; };

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(display).xy))) return;
  imageStore(display, pixel, displayColor(push, texelFetch(picture, pixel, 0)));
}
