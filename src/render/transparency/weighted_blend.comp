#version 460
// Weighted blended OIT, last pass: blends the mean color of each pixel's blended surfaces over the lit picture. Inputs:
// colors and weights. Input and output: lightTarget.
layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray colors;  // the sums of blended_weighted.frag
layout(set = 0, binding = 1) uniform sampler2DArray weights;
layout(set = 0, binding = 2, rgba16f) uniform image2DArray lightTarget;

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(lightTarget).xy))) return;
  vec4 sum = texelFetch(colors, place, 0);
  float weight = texelFetch(weights, place, 0).r;
  if (weight <= 0.0) return;
  vec4 mean = vec4(sum.rgb / weight, 1.0) * sum.a;
  vec4 picture = imageLoad(lightTarget, place);
  imageStore(lightTarget, place, min(mean + picture * (1.0 - sum.a), vec4(vec3(65504.0), 1.0)));
}
