#version 460
#extension GL_GOOGLE_include_directive : require
// Composes the finished picture: tone mapping, background color, sRGB, 8 bits.
#include "render/post/compose.glsl"
#include "render/glsl/covered_tiles.glsl"

// 16x16 pixels, or a covered tile.
layout(local_size_x = kPixelGroupX, local_size_y_id = kComposedRowsConstant) in;
layout(set = 0, binding = 0) uniform sampler2DArray picture;  // linear, premultiplied by alpha
layout(push_constant, scalar) uniform Push { ComposePush push; };

void main() {
  uvec3 block = ownBlock(push.covered);
  ivec3 pixel = ivec3(block.xy * gl_WorkGroupSize.xy + gl_LocalInvocationID.xy, block.z);
  ivec2 size = textureSize(picture, 0).xy;
  if (any(greaterThanEqual(pixel.xy, size))) return;
  uint code = displayCode(displayColor(push, texelFetch(picture, pixel, 0)));
  writeCode(push, pixel, size, code);
}
