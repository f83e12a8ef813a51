#version 460
// forward-multipass, the end: the sum of all passes becomes the lit picture.
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray lightSum;
layout(set = 0, binding = 1, rgba16f) uniform writeonly image2DArray lightTarget;

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel.xy, imageSize(lightTarget).xy))) return;
  imageStore(lightTarget, pixel, min(texelFetch(lightSum, pixel, 0), vec4(65504.0)));
}
