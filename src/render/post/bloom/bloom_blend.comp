#version 460
#extension GL_GOOGLE_include_directive : require
// Bloom, last pass: replaces a fraction of the picture's light by the glow. Light is redistributed, not added.
#include "render/post/bloom/bloom.glsl"
#include "render/post/bloom/bloom_up.glsl"

layout(set = 0, binding = 0) uniform sampler2DArray picture;  // linear, premultiplied by alpha
layout(set = 0, binding = 1) uniform sampler2DArray glow;     // half the size of the picture
layout(set = 0, binding = 2, rgba32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { BloomBlendPush push; };

void main() {
  vec3 arrives = enlarged(glow, imageSize(result).xy) * push.strength;
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(result).xy))) return;
  vec4 c = texelFetch(picture, place, 0) * push.scale;
  vec3 leaves = glowing(c.rgb, push.threshold) * push.strength;
  // With straight alpha, light over a transparent background is visible only with coverage. Its coverage is the value
  // of its brightest channel.
  float alpha = c.a + (1.0 - c.a) * min(maxChannel(arrives), 1.0);
  imageStore(result, place, vec4(c.rgb + (arrives - leaves), alpha));
}
