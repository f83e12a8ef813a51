#version 460
#extension GL_GOOGLE_include_directive : require
// Half the size by 13 taps (Jimenez 2014, Next Generation Post Processing in Call of Duty: Advanced Warfare, SIGGRAPH course
// Advances in Real-Time Rendering): five groups of four taps, each the mean of 2 by 2 texels; the one in the middle counts
// one half, the four around it an eighth each. A workgroup shares its taps: two or three for each texel.
#include "render/post/bloom/bloom.glsl"

const int kSide = 16;
layout(local_size_x = kSide, local_size_y = kSide) in;
layout(constant_id = 16) const uint kDamp = 0;  // Karis' average in each group
layout(set = 0, binding = 0) uniform sampler2DArray source;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { BloomDownPush push; };

// Taps lie two texels apart in two grids: the outer ones from two texels before the workgroup's first on, the inner
// ones from one before.
const int kOuter = kSide + 2, kInner = kSide + 1;
shared vec3 outer[kOuter * kOuter];
shared vec3 inner[kInner * kInner];

// Mean of the four texels from `corner` on.
vec3 tap(ivec3 corner, ivec2 size) {
  vec3 sum = vec3(0.0);
  for (int i = 0; i < 4; ++i) {
    ivec2 place = mirrored(corner.xy + ivec2(i & 1, i >> 1), size);
    sum += glowing(texelFetch(source, ivec3(place, corner.z), 0).rgb * push.scale, push.threshold);
  }
  return sum * 0.25;
}

void shareTaps() {
  ivec2 size = textureSize(source, 0).xy;
  ivec3 first = ivec3(ivec2(gl_WorkGroupID.xy) * (2 * kSide), gl_GlobalInvocationID.z);
  for (int i = int(gl_LocalInvocationIndex); i < kOuter * kOuter; i += kSide * kSide)
    outer[i] = tap(first + ivec3(2 * (i % kOuter) - 2, 2 * (i / kOuter) - 2, 0), size);
  for (int i = int(gl_LocalInvocationIndex); i < kInner * kInner; i += kSide * kSide)
    inner[i] = tap(first + ivec3(2 * (i % kInner) - 1, 2 * (i / kInner) - 1, 0), size);
  barrier();
}

// Karis 2013 (Tone mapping, graphicrants.blogspot.com): a mean in which brighter texels count less, so that a single
// one does not outshine all others.
vec3 groupMean(vec3 a, vec3 b, vec3 c, vec3 d) {
  if (kDamp == 0u) return (a + b + c + d) * 0.25;
  vec4 w = 1.0 / (1.0 + vec4(luminance(a), luminance(b), luminance(c), luminance(d)));
  return (a * w.x + b * w.y + c * w.z + d * w.w) / (w.x + w.y + w.z + w.w);
}

void main() {
  shareTaps();
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(place.xy, imageSize(result).xy))) return;
  ivec2 local = ivec2(gl_LocalInvocationID.xy);
  int at = local.y * kInner + local.x;
  vec3 sum = 0.5 * groupMean(inner[at], inner[at + 1], inner[at + kInner], inner[at + kInner + 1]);
  for (int i = 0; i < 4; ++i) {
    int first = (local.y + (i >> 1)) * kOuter + local.x + (i & 1);
    sum += 0.125 * groupMean(outer[first], outer[first + 1], outer[first + kOuter], outer[first + kOuter + 1]);
  }
  imageStore(result, place, vec4(sum, 0.0));
}
