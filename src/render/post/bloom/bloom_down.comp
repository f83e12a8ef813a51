#version 460
#extension GL_GOOGLE_include_directive : require
// Bloom, downsampling: halves the size of a level with a filter of 13 taps (Jimenez 2014, Next Generation Post
// Processing in Call of Duty: Advanced Warfare, SIGGRAPH course Advances in Real-Time Rendering). A tap is the mean
// over an area as large as a texel of the result, which is 2x2 texels of an even source. Taps form five groups of four:
// the center group has weight 1/2, the four groups around it 1/8 each. Invocations of a workgroup share their taps, so
// each texel computes two or three. Input: source. Output: result.
#include "render/post/bloom/bloom.glsl"

const int kSide = 16;
layout(local_size_x = kSide, local_size_y = kSide) in;
layout(constant_id = kDampConstant) const uint kDamp = 0;  // 1: Karis average in each group
layout(set = 0, binding = 0) uniform sampler2DArray source;
layout(set = 0, binding = 1, rgba32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { BloomDownPush push; };

// Taps form two grids with a spacing of one texel of the result. The outer grid has the areas of its texels, beginning
// one texel before the first of the workgroup. The areas of the inner grid are centered at the corners of texels.
const int kOuter = kSide + 2, kInner = kSide + 1;
shared vec3 outer[kOuter * kOuter];
shared vec3 inner[kInner * kInner];

// The mean over the area of one texel of the result around `center`, in half texels of the result. At the edges of the
// source, areas that are outside equal their mirror images, and areas that are partly outside equal their inner halves.
vec3 tap(ivec2 center) {
  ivec2 size = textureSize(source, 0).xy, halves = 2 * imageSize(result).xy;
  center = clamp(center, center & 1, halves - (center & 1));
  // In units that make the borders of texels of both the source and the result integers, so that areas add up exactly.
  ivec2 from = max(center - 1, 0) * size, to = min(center + 1, halves) * size;
  ivec2 first = from / halves, last = (to - 1) / halves;
  vec3 sum = vec3(0.0);
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      ivec2 place = ivec2(x, y);
      vec2 share = vec2(min(to, (place + 1) * halves) - max(from, place * halves)) / vec2(to - from);
      vec3 c = texelFetch(source, ivec3(place, gl_GlobalInvocationID.z), 0).rgb * push.scale;
      sum += share.x * share.y * glowing(c, push.threshold);
    }
  return sum;
}

void shareTaps() {
  ivec2 first = ivec2(gl_WorkGroupID.xy) * kSide;
  for (int i = int(gl_LocalInvocationIndex); i < kOuter * kOuter; i += kSide * kSide)
    outer[i] = tap(2 * (first + ivec2(i % kOuter, i / kOuter)) - 1);
  for (int i = int(gl_LocalInvocationIndex); i < kInner * kInner; i += kSide * kSide)
    inner[i] = tap(2 * (first + ivec2(i % kInner, i / kInner)));
  barrier();
}

// The Karis average (Karis 2013, Tone mapping, graphicrants.blogspot.com): a mean that gives brighter texels less
// weight, so a single one does not dominate the result.
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
