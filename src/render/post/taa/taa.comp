#version 460
#extension GL_GOOGLE_include_directive : require
// Temporal anti-aliasing (TAA): reprojects the history with the motion vectors, clips it to the colors around the pixel
// (variance clipping), and blends the current jittered frame into it. docs/taa.md explains each step. Inputs: frame,
// depth, motion, oldColor, oldState. Outputs: newColor, newState. The state of a pixel is r: nearness(), g: the number
// of samples in the color, b: the speed, which is the longer of the motions to the previous and to the next frame, in
// pixels, a: the exposure of the color. Sources: Karis 2014, High Quality Temporal Supersampling, SIGGRAPH; Salvi 2016,
// An Excursion in Temporal Supersampling, GDC; Jimenez 2016, Filmic SMAA, SIGGRAPH (the bicubic filter of nine bilinear
// fetches).
#include "render/glsl/common.glsl"
#include "render/post/taa/temporal_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray frame;     // jittered frame, or the sum of the first frames
layout(set = 0, binding = 1) uniform sampler2DArray depth;     // of the jittered frame
layout(set = 0, binding = 2) uniform sampler2DArray motion;    // pixels: xy to the previous frame, zw to the next
layout(set = 0, binding = 3) uniform sampler2DArray oldColor;  // history from the previous frame; linear filter
layout(set = 0, binding = 4) uniform sampler2DArray oldState;  // see above
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2DArray newColor;
layout(set = 0, binding = 6, rgba32f) uniform writeonly image2DArray newState;

layout(push_constant, scalar) uniform Push { TemporalPush push; };

// The maximum number of samples in a mean. Each reprojection blurs a moving pixel slightly, so its history must be
// shorter.
const float kMaxStill = 64.0, kMaxMoving = 5.0;
// The size of the neighborhood's color box in standard deviations (Salvi's gamma). The box must contain most valid
// history.
const float kGamma = 1.0;
// The history of a still pixel is clipped only by this fraction. Otherwise detail that only some of the jittered
// samples hit would flicker.
const float kStillPull = 0.1;
// In pixels: motion below this may be zero motion rounded to half floats.
const float kStill = 0.005;
const float kDepthTolerance = 1.1;

// 1 / view depth in 1/m, 0 for the background; device depth in an orthographic view.
float nearness(View view, ivec3 pixel) {
  float d = texelFetch(depth, pixel, 0).r;
  if (view.projection.kind != kPerspective) return d;
  return d == 0.0 ? 0.0 : 1.0 / viewDepth(view.projection, d);
}

float luma(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }

// Compresses bright colors (Karis's weight), then converts to luma and chroma (YCoCg), in which color boxes are tight.
vec4 toBoxSpace(vec4 c) {
  vec3 t = c.rgb / (1.0 + max(luma(c.rgb), 0.0));
  return vec4(dot(t, vec3(0.25, 0.5, 0.25)), dot(t, vec3(0.5, 0.0, -0.5)), dot(t, vec3(-0.25, 0.5, -0.25)), c.a);
}
vec4 fromBoxSpace(vec4 b) {
  vec3 t = vec3(b.x + b.y - b.z, b.x + b.z, b.x - b.y - b.z);
  t = max(t, vec3(0.0));
  return vec4(t / max(1.0 - luma(t), 1e-4), clamp(b.w, 0.0, 1.0));
}

struct Near {  // statistics of the 3x3 neighborhood
  vec4 mean, deviation, smoothed;
  float least, most;  // minimum and maximum nearness
  ivec3 nearest;
};

Near lookAround(View view, ivec3 pixel, ivec2 size) {
  Near n;
  vec4 sum = vec4(0.0), squares = vec4(0.0);
  n.smoothed = vec4(0.0);
  n.least = 1e30;
  n.most = -1.0;
  n.nearest = pixel;
  for (int i = 0; i < 9; ++i) {
    ivec2 offset = ivec2(i % 3 - 1, i / 3 - 1);
    ivec3 at = ivec3(clamp(pixel.xy + offset, ivec2(0), size - 1), pixel.z);
    vec4 color = texelFetch(frame, at, 0);
    vec4 b = toBoxSpace(color);
    sum += b;
    squares += b * b;
    n.smoothed += color * (float(2 - abs(offset.x)) * float(2 - abs(offset.y)) / 16.0);
    float near = nearness(view, at);
    n.least = min(n.least, near);
    if (near > n.most) {
      n.most = near;
      n.nearest = at;
    }
  }
  n.mean = sum / 9.0;
  n.deviation = sqrt(max(squares / 9.0 - n.mean * n.mean, vec4(0.0)));
  return n;
}

// Samples the history with a Catmull-Rom filter, which blurs less per step than bilinear filtering.
vec4 sampleHistory(vec2 position, ivec2 size, int layer) {
  vec2 center = floor(position - 0.5) + 0.5, f = position - center;
  vec2 w0 = f * (-0.5 + f * (1.0 - 0.5 * f)), w1 = 1.0 + f * f * (-2.5 + 1.5 * f);
  vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f)), w3 = f * f * (-0.5 + 0.5 * f);
  vec2 middle = w1 + w2;
  vec2 at[3] = vec2[3](center - 1.0, center + w2 / middle, center + 2.0);
  vec2 weight[3] = vec2[3](w0, middle, w3);
  vec4 sum = vec4(0.0);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x)
      sum += textureLod(oldColor, vec3(vec2(at[x].x, at[y].y) / vec2(size), layer), 0.0) * weight[x].x * weight[y].y;
  return max(sum, vec4(0.0));
}

// Variance clipping (Salvi): moves the history toward the center of the box until it is inside. Clamping each channel
// separately would change the hue.
vec4 clipToBox(vec4 history, Near n) {
  vec4 offset = history - n.mean;
  vec4 units = abs(offset) / max(n.deviation * kGamma, vec4(1e-4));
  float farthest = max(max(units.x, units.y), max(units.z, units.w));
  return farthest > 1.0 ? n.mean + offset / farthest : history;
}

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  ivec2 size = textureSize(frame, 0).xy;
  if (any(greaterThanEqual(pixel.xy, size))) return;
  View view = frameView(FrameRef(push.frame).v, uint(pixel.z));
  float exposure = frameOf(push.frame, uint(pixel.z)).exposure;
  vec4 current = texelFetch(frame, pixel, 0) * push.scale;
  float here = nearness(view, pixel);
  Near near = lookAround(view, pixel, size);
  // Use the motion of the nearest surface in the neighborhood, so edges move with their object (Karis).
  vec4 way = texelFetch(motion, near.nearest, 0);
  vec2 moved = way.xy;
  float speed = max(length(way.xy), length(way.zw));
  if (push.samples > 0.0) {
    imageStore(newColor, pixel, current);
    imageStore(newState, pixel, vec4(here, push.samples, speed, exposure));
    return;
  }

  vec2 before = vec2(pixel.xy) + 0.5 + moved;
  bool inside = all(greaterThanEqual(before, vec2(0.0))) && all(lessThan(before, vec2(size)));

  ivec3 from = ivec3(clamp(ivec2(floor(before)), ivec2(0), size - 1), pixel.z);
  vec4 state = texelFetch(oldState, from, 0);
  float moving = clamp(max(length(moved), state.b) * 4.0, 0.0, 1.0);  // or has moved: part of an edge may remain
  bool uncovered = state.r > near.most * kDepthTolerance + 1e-6 || state.r * kDepthTolerance + 1e-6 < near.least;
  // Restart the history at disocclusions and outside of the previous frame. If nothing moves, a change in depth is no
  // disocclusion but subpixel detail that this jittered sample missed.
  if (!inside || (uncovered && moving > 4.0 * kStill)) {
    imageStore(newColor, pixel, near.smoothed);
    imageStore(newState, pixel, vec4(here, 1.0, speed, exposure));
    return;
  }

  vec4 history = length(moved) > kStill ? sampleHistory(before, size, pixel.z) : texelFetch(oldColor, from, 0);
  // Division may round, so equal exposures are compared instead.
  history.rgb *= exposure == state.a ? 1.0 : exposure / state.a;
  vec4 box = toBoxSpace(history);
  history = fromBoxSpace(mix(box, clipToBox(box, near), mix(kStillPull, 1.0, moving)));
  float count = min(state.g + 1.0, mix(kMaxStill, kMaxMoving, moving));
  imageStore(newColor, pixel, mix(history, current, 1.0 / count));
  imageStore(newState, pixel, vec4(here, count, speed, exposure));
}
