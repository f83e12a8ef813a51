#version 460
#extension GL_GOOGLE_include_directive : require
// Blends the color towards its luminance in brown.
#include "render/glsl/common.glsl"
#include "render/post/sepia/sepia_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray picture;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { SepiaPush push; };

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(result).xy))) return;
  vec4 c = texelFetch(picture, place, 0);
  vec3 brown = dot(c.rgb, vec3(0.2126, 0.7152, 0.0722)) * vec3(1.2, 1.0, 0.7);
  imageStore(result, place, vec4(mix(c.rgb, brown, push.strength), c.a));
}
