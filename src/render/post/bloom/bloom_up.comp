#version 460
#extension GL_GOOGLE_include_directive : require
// Bloom, upsampling: mixes a level (fine) with the enlarged sum of the coarser levels (coarse), by the weight `radius`.
#include "render/post/bloom/bloom.glsl"
#include "render/post/bloom/bloom_up.glsl"

layout(set = 0, binding = 0) uniform sampler2DArray fine;
layout(set = 0, binding = 1) uniform sampler2DArray coarse;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { BloomUpPush push; };

void main() {
  vec3 above = enlarged(coarse, imageSize(result).xy);
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(result).xy))) return;
  imageStore(result, place, vec4(mix(texelFetch(fine, place, 0).rgb, above, push.radius), 0.0));
}
