#version 460
// Adds one jittered frame to the sum of them (ordered super-sampling).
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray frame;
layout(set = 0, binding = 1, rgba32f) uniform image2DArray sum;

layout(push_constant) uniform Push { uint first; };

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(sum).xy))) return;
  vec4 before = first != 0u ? vec4(0.0) : imageLoad(sum, pixel);
  imageStore(sum, pixel, before + texelFetch(frame, pixel, 0));
}
