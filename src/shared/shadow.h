// Shadow maps: where a point lies in one, and how what is stored there becomes light (render/glsl/shadow.glsl, and the
// tests' copy of it on the host). Depth is linear in metres between a map's near and far, so that 16 bits resolve a
// perspective map alike everywhere.
#ifndef LATELIGHT_SHARED_SHADOW_H
#define LATELIGHT_SHARED_SHADOW_H

#include "shared/depth_packing.h"
#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

// How depth is stored, as ShadowFormat numbers it.
SH_CONST uint kShadowNone = 0u;
SH_CONST uint kShadowD32 = 1u;
SH_CONST uint kShadowD16 = 2u;
SH_CONST uint kShadowRgba8 = 3u;
SH_CONST uint kShadowRgba8Classic = 4u;

// How stored depths become light, as ShadowFilter numbers it.
SH_CONST uint kShadowFilterHard = 0u;
SH_CONST uint kShadowFilterPcf = 1u;
SH_CONST uint kShadowFilterPcss = 2u;

// No surface is stored as 1: that is what nothing is, and what rgba8-classic makes 0 of. One level of 16 bits below.
SH_CONST float kShadowFarthest = 65534.0f / 65535.0f;

// --- bias -----------------------------------------------------------------------------------------------------------
//
// A texel's depth stands for the whole texel, and the filter compares with texels up to its reach away. On a plane of
// slope m = tan(angle to the light) depth differs by m reach texels over that distance. Two biases cover that, each by
// itself where it can be trusted:
//
// The map is biased by the exact plane of the triangle that is drawn (shadow.frag), up to slope kShadowCasterSlope: no
// normal takes part, so a normal map can't undo it. But it knows nothing of a steeper face beside that triangle.
//
// The receiving point comes nearer to the light by its own plane, up to slope kShadowSlope, and beyond that is moved
// along its normal by the remainder (normal offset: Holbein 2011, Saying "Goodbye" to Shadow Acne, GDC), which is
// bounded where a slope is not. Its normal is the shaded one, that every layout has.

SH_CONST float kShadowCasterSlope = 1.0f;
SH_CONST float kShadowSlope = 2.0f;
// For surfaces that are no planes within a texel, and for rounding: texels.
SH_CONST float kShadowConstantBias = 0.5f;

// How far from the point a filter looks, along each axis, texels. PCSS biases its wide kernels by itself.
SH_FUNC float shadowReach(uint filterKind) {
  return filterKind == kShadowFilterHard ? 0.5f : 1.5f;
}

// Depth to add to a surface whose depth changes by (dx, dy) from a texel to the next; `unit`: depth a texel on a plane
// of slope 1.
SH_FUNC float shadowCasterBias(float dx, float dy, float unit, uint filterKind) {
  float steepest = kShadowCasterSlope * 1.41421356f * unit;  // of |dx| + |dy|
  return min(abs(dx) + abs(dy), steepest) * shadowReach(filterKind) + kShadowConstantBias * unit;
}

// How far from the point a filter looks in any direction, metres, where texels are `width` metres wide.
SH_FUNC float shadowRadius(float width, uint filterKind) {
  return 1.41421356f * shadowReach(filterKind) * width;
}

// What a point's normal has across the map's axis (x) and against the ray that meets the point (y), rays being 1 long
// along the axis. The slope of the point's plane is x / y.
SH_FUNC vec2 shadowSlope(ShadowMap m, vec3 n, vec3 toLight) {
  vec3 axis = vec3(m.away.x, m.away.y, m.away.z);
  float along = dot(n, axis);
  return vec2(sqrt(max(1.0f - along * along, 0.0f)), max(dot(n, toLight), 0.0f) / max(-dot(toLight, axis), 1e-3f));
}

// Depth to take from a point for its plane's slope.
SH_FUNC float shadowReceiverBias(ShadowMap m, vec2 slope, float width, uint filterKind) {
  return min(slope.x / max(slope.y, 1e-3f), kShadowSlope) * shadowRadius(width, filterKind) * m.depthScale;
}

// Metres to move a point along its normal for what its slope has beyond that.
SH_FUNC float shadowNormalOffset(vec2 slope, float width, uint filterKind) {
  return max(slope.x - kShadowSlope * slope.y, 0.0f) * shadowRadius(width, filterKind);
}

// --- lookup ---------------------------------------------------------------------------------------------------------

// The face of the cube of maps that a direction from the light falls in: +x, -x, +y, -y, +z, -z.
SH_FUNC uint shadowFace(vec3 d) {
  vec3 a = vec3(abs(d.x), abs(d.y), abs(d.z));
  if (a.x >= a.y && a.x >= a.z) return d.x >= 0.0f ? 0u : 1u;
  if (a.y >= a.z) return d.y >= 0.0f ? 2u : 3u;
  return d.z >= 0.0f ? 4u : 5u;
}

struct ShadowPoint {
  vec2 texel;   // from the first corner of its tile
  float depth;  // 0 to 1 within the map
  float away;   // metres along the map's axis
  float width;  // of a texel there, metres
};

SH_FUNC ShadowPoint shadowPoint(ShadowMap m, vec3 p) {
  vec4 q = vec4(p.x, p.y, p.z, 1.0f);
  ShadowPoint s;
  s.away = dot(m.away, q);
  float w = 1.0f + (s.away - 1.0f) * m.perspective;
  s.texel = vec2(dot(m.across, q) / w, dot(m.down, q) / w);
  s.depth = s.away * m.depthScale + m.depthOffset;
  s.width = m.texel * w;
  return s;
}

// Whether the texel lies in the tile with this room around it.
SH_FUNC bool shadowInside(ShadowMap m, vec2 texel, float room) {
  return texel.x >= room && texel.y >= room && texel.x <= m.size - room && texel.y <= m.size - room;
}

// Of the quadratic B-spline, over the texel that holds a point and its two neighbours along an axis: the filter is 3
// texels wide, smooth to its first derivative, and sums to 1. `offset`: of the point from that texel's centre, -1/2 to
// 1/2.
SH_FUNC vec3 shadowWeights(float offset) {
  float before = 0.5f - offset, after = 0.5f + offset;
  return vec3(0.5f * before * before, 0.75f - offset * offset, 0.5f * after * after);
}

// Percentage-closer soft shadows (Fernando 2005): the light's own size, in texels about the point.
SH_CONST uint kShadowSearchTaps = 16u;
SH_CONST uint kShadowPcssTaps = 64u;
// A kernel's radius is at most this share of its tile.
SH_CONST float kShadowWidest = 0.125f;

// The i-th of n points spread evenly over the unit disc (Vogel 1979): the golden angle apart, always the same.
SH_FUNC vec2 shadowTap(uint i, uint n) {
  float radius = sqrt((float(i) + 0.5f) / float(n)), angle = float(i) * 2.39996323f;
  return vec2(radius * cos(angle), radius * sin(angle));
}

// Metres at the receiving point, about it, of the light seen through a hole at `blocker`; both metres along the axis.
SH_FUNC float shadowPenumbra(ShadowMap m, float receiver, float blocker) {
  float behind = max(receiver - blocker, 0.0f);
  return m.lightSize * (m.perspective > 0.5f ? behind / max(blocker, 1e-6f) : behind);
}

// Depth a texel across and down on the plane through the point, for kernels wider than the map's own bias reaches. The
// slope is bounded: a grazing plane, or a normal that is not the plane's, must not look behind everything.
SH_FUNC vec2 shadowPlane(ShadowMap m, vec3 n, vec3 toLight, float width) {
  vec3 right = vec3(m.across.x, m.across.y, m.across.z), down = vec3(m.down.x, m.down.y, m.down.z);
  vec3 axis = vec3(m.away.x, m.away.y, m.away.z);
  // In a perspective map the rows have a share of the axis, which is taken out.
  right = right - axis * dot(right, axis);
  down = down - axis * dot(down, axis);
  float facing = shadowSlope(m, n, toLight).y;
  float scale = width / max(facing, 1e-3f);
  vec2 slope = vec2(dot(n, right) * inversesqrt(max(dot(right, right), 1e-20f)) * scale,
                    dot(n, down) * inversesqrt(max(dot(down, down), 1e-20f)) * scale);
  float steep = sqrt(slope.x * slope.x + slope.y * slope.y) / width;
  float bound = steep > 2.0f * kShadowSlope ? 2.0f * kShadowSlope / steep : 1.0f;
  return slope * (bound * m.depthScale);
}

SH_END

#endif
