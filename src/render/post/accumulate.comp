#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
// Supersampling: adds one jittered frame to the sum of the frames of a picture.
#include "render/post/accumulate_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray frame;
layout(set = 0, binding = 1, rgba32f) uniform image2DArray sum;
layout(push_constant, scalar) uniform Push { AccumulatePush push; };

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(sum).xy))) return;
  vec4 before = push.first != 0u ? vec4(0.0) : imageLoad(sum, pixel);
  imageStore(sum, pixel, before + texelFetch(frame, pixel, 0));
}
