#version 460
#extension GL_GOOGLE_include_directive : require
// A level of glow: its own share, plus that of the coarser levels.
#include "render/post/bloom/bloom.glsl"
#include "render/post/bloom/bloom_up.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray fine;
layout(set = 0, binding = 1) uniform sampler2DArray coarse;
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { BloomUpPush push; };

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(result).xy))) return;
  imageStore(result, place, vec4(mix(texelFetch(fine, place, 0).rgb, enlarged(coarse, place), push.radius), 0.0));
}
