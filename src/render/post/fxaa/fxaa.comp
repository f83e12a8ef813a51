#version 460
#extension GL_GOOGLE_include_directive : require
// FXAA, fast approximate anti-aliasing, written from the description of the quality path of FXAA 3.11 (Lottes 2009,
// FXAA, NVIDIA white paper). If a pixel has high contrast, the shader determines the direction of the edge, follows the
// edge to both ends, and blends in the neighbor across the edge by the area that a line from end to end would cover.
// Input: display. Output: the finished picture.
//
// Light is blended linearly, as with more samples per pixel. Contrast is measured in the square root of light, which is
// close to the picture's encoding. If opacity changes more than light does, the edge is one of opacity.
#include "render/post/compose.glsl"

const int kSide = 16;
layout(local_size_x = kSide, local_size_y = kSide) in;
layout(set = 0, binding = 0) uniform sampler2DArray display;  // linear, straight alpha
layout(push_constant, scalar) uniform Push { ComposePush push; };

const float kMinContrast = 1.0 / 32.0;   // minimum contrast of a visible edge; pictures are in [0, 1]
const float kMinRelative = 1.0 / 8.0;    // minimum contrast relative to the brightest neighbor
const float kSubpixel = 0.75;              // softening of isolated pixels, 0 to 1
const int kSearchSteps = 11;
const int kSearchStep[kSearchSteps] = int[](1, 1, 1, 1, 1, 2, 2, 2, 2, 4, 8);

struct Pixel {
  ivec3 place;
  ivec2 size;
  bool byAlpha;
};

vec4 fetch(Pixel p, ivec2 offset) {
  return texelFetch(display, ivec3(clamp(p.place.xy + offset, ivec2(0), p.size - 1), p.place.z), 0);
}

vec2 signals(vec4 c) { return vec2(sqrt(luminance(c.rgb) * c.a), c.a); }

float signalOf(Pixel p, vec2 signals) { return p.byAlpha ? signals.y : signals.x; }

float at(Pixel p, ivec2 offset) { return signalOf(p, signals(fetch(p, offset))); }

// Signals of the workgroup's pixels and their neighbors; most pixels need no others. (On lavapipe, fetching them
// directly is an eighth faster, because lavapipe reads shared memory lane by lane.)
const int kWide = kSide + 2;
shared vec2 nearSignals[kWide * kWide];

void shareSignals() {
  if (kCpuDevice != 0u) return;
  ivec3 corner = ivec3(ivec2(gl_WorkGroupID.xy) * kSide - 1, gl_GlobalInvocationID.z);
  Pixel first = Pixel(corner, textureSize(display, 0).xy, false);
  for (int i = int(gl_LocalInvocationIndex); i < kWide * kWide; i += kSide * kSide)
    nearSignals[i] = signals(fetch(first, ivec2(i % kWide, i / kWide)));
  barrier();
}

// The signals of a pixel at most one pixel away along each axis.
vec2 near(Pixel p, ivec2 offset) {
  if (kCpuDevice != 0u) return signals(fetch(p, offset));
  ivec2 place = ivec2(gl_LocalInvocationID.xy) + 1 + offset;
  return nearSignals[place.y * kWide + place.x];
}

// The mean of a pixel of the edge's row and its neighbor across the edge.
float edgeAt(Pixel p, ivec2 offset, ivec2 across) { return 0.5 * (at(p, offset) + at(p, offset + across)); }

// The end of the edge on one side: its distance in pixels, and the change of the mean across the edge there.
struct End {
  float distance, change;
  bool found;
};

void search(inout End end, Pixel p, ivec2 along, ivec2 across, float mean, float limit, int reached) {
  if (end.found) return;
  end.distance = float(reached);
  end.change = edgeAt(p, along * reached, across) - mean;
  end.found = abs(end.change) >= limit;
}

// The fraction of the neighbor across the edge to blend in.
float coverage(Pixel p, ivec2 along, ivec2 across, float here, float there) {
  float mean = 0.5 * (here + there), limit = 0.25 * abs(there - here);
  End back = End(0.0, 0.0, false), ahead = End(0.0, 0.0, false);
  int reached = 0;
  for (int i = 0; i < kSearchSteps && !(back.found && ahead.found); ++i) {
    reached += kSearchStep[i];
    search(back, p, -along, across, mean, limit, reached);
    search(ahead, p, along, across, mean, limit, reached);
  }
  End nearer = back.distance < ahead.distance ? back : ahead;
  // The nearer end must bend to this pixel's side, otherwise the line covers part of the neighbor instead.
  bool bends = (nearer.change < 0.0) != (here - mean < 0.0);
  return bends ? 0.5 - nearer.distance / (back.distance + ahead.distance) : 0.0;
}

vec4 premultiplied(vec4 c) { return vec4(c.rgb * c.a, c.a); }

vec4 straight(vec4 c) { return vec4(c.a > 0.0 ? c.rgb / c.a : vec3(0.0), c.a); }

vec4 antialiased(Pixel p) {
  vec4 middle = fetch(p, ivec2(0));
  vec2 m = near(p, ivec2(0)), n = near(p, ivec2(0, -1)), s = near(p, ivec2(0, 1)), w = near(p, ivec2(-1, 0)),
       e = near(p, ivec2(1, 0));
  vec2 most = max(m, max(max(n, s), max(w, e))), least = min(m, min(min(n, s), min(w, e)));
  vec2 contrast = most - least;
  p.byAlpha = contrast.y > contrast.x;
  float range = p.byAlpha ? contrast.y : contrast.x;
  if (range < max(kMinContrast, kMinRelative * (p.byAlpha ? most.y : most.x))) return middle;

  float M = signalOf(p, m), N = signalOf(p, n), S = signalOf(p, s), W = signalOf(p, w), E = signalOf(p, e);
  float NW = signalOf(p, near(p, ivec2(-1, -1))), NE = signalOf(p, near(p, ivec2(1, -1))),
        SW = signalOf(p, near(p, ivec2(-1, 1))), SE = signalOf(p, near(p, ivec2(1, 1)));
  float mean = (2.0 * (N + S + W + E) + NW + NE + SW + SE) / 12.0;
  float lone = smoothstep(0.0, 1.0, min(abs(mean - M) / range, 1.0));
  float acrossRows = abs(NW + SW - 2.0 * W) + 2.0 * abs(N + S - 2.0 * M) + abs(NE + SE - 2.0 * E);
  float acrossColumns = abs(NW + NE - 2.0 * N) + 2.0 * abs(W + E - 2.0 * M) + abs(SW + SE - 2.0 * S);
  bool horizontal = acrossRows >= acrossColumns;
  float before = horizontal ? N : W, after = horizontal ? S : E;
  bool towardsBefore = abs(before - M) >= abs(after - M);
  ivec2 along = horizontal ? ivec2(1, 0) : ivec2(0, 1);
  ivec2 across = (horizontal ? ivec2(0, 1) : ivec2(1, 0)) * (towardsBefore ? -1 : 1);
  float share = max(coverage(p, along, across, M, towardsBefore ? before : after), lone * lone * kSubpixel);
  return straight(mix(premultiplied(middle), premultiplied(fetch(p, across)), share));
}

void main() {
  shareSignals();
  Pixel p = Pixel(ivec3(gl_GlobalInvocationID), textureSize(display, 0).xy, false);
  if (any(greaterThanEqual(p.place.xy, p.size))) return;
  writeCode(push, p.place, p.size, displayCode(antialiased(p)));
}
