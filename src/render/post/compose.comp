#version 460
#extension GL_GOOGLE_include_directive : require
// Composes the finished picture: tone mapping, background color, sRGB, 8 bits.
#include "render/post/compose.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray picture;  // linear, premultiplied by alpha
layout(push_constant, scalar) uniform Push { ComposePush push; };

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  ivec2 size = textureSize(picture, 0).xy;
  if (any(greaterThanEqual(pixel.xy, size))) return;
  uint code = displayCode(displayColor(push, texelFetch(picture, pixel, 0)));
  writeCode(push, pixel, size, code);
}
