#version 460
#extension GL_GOOGLE_include_directive : require
// Transmission background: writes one level of the pyramid of the opaque picture that transmissive surfaces sample.
// Level 0 is a copy of the picture; each other level is the previous one at half its size. The filter is four texels
// wide, so magnified levels show no blocks. Input: picture. Output: levels, in the arrangement of behind_push.h.
#include "render/layered/behind_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant) uniform Push { BackgroundMipPush push; };
layout(set = 0, binding = 0) uniform sampler2DArray picture;
layout(set = 0, binding = 1, rgba32f) uniform image2DArray levels;

vec4 finer(ivec2 texel, int view, uvec2 size) {
  ivec2 corner = ivec2(backgroundMipCorner(size, push.level - 1u));
  ivec2 last = ivec2(backgroundMipSize(size, push.level - 1u)) - 1;
  return imageLoad(levels, ivec3(corner + clamp(texel, ivec2(0), last), view));
}

vec4 halved(ivec2 texel, int view, uvec2 size) {
  const vec4 kWeights = vec4(1.0, 3.0, 3.0, 1.0) / 8.0;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      sum += finer(2 * texel + ivec2(x - 1, y - 1), view, size) * (kWeights[x] * kWeights[y]);
  return sum;
}

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  uvec2 size = uvec2(textureSize(picture, 0).xy);
  if (any(greaterThanEqual(uvec2(place.xy), backgroundMipSize(size, push.level)))) return;
  vec4 found = push.level == 0u ? texelFetch(picture, place, 0) : halved(place.xy, place.z, size);
  imageStore(levels, ivec3(ivec2(backgroundMipCorner(size, push.level)) + place.xy, place.z), found);
}
