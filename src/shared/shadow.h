// Shadow map lookup: projects a point into a map, computes depth biases, and provides the filter kernels for PCF and
// PCSS (render/glsl/shadow.glsl, and the tests' copy of it on the host). Depth is linear in meters between a map's near
// and far, so 16 bits have the same resolution everywhere in a perspective map.
#ifndef LATELIGHT_SHARED_SHADOW_H
#define LATELIGHT_SHARED_SHADOW_H

#include "shared/depth_packing.h"
#include "shared/lang.h"
#include "shared/types.h"

SH_BEGIN

// The storage format of depth; the values match ShadowFormat.
SH_CONST uint kShadowNone = 0u;
SH_CONST uint kShadowD32 = 1u;
SH_CONST uint kShadowD16 = 2u;
SH_CONST uint kShadowRgba8 = 3u;
SH_CONST uint kShadowRgba8Classic = 4u;

// The shadow filter; the values match ShadowFilter.
SH_CONST uint kShadowFilterHard = 0u;
SH_CONST uint kShadowFilterPcf = 1u;
SH_CONST uint kShadowFilterPcss = 2u;

// The maximum stored depth of a surface, one 16-bit level below 1. A depth of 1 means an empty texel, and rgba8-classic
// turns it into 0.
SH_CONST float kShadowFarthest = 65534.0f / 65535.0f;

// --- bias -----------------------------------------------------------------------------------------------------------
//
// A texel's depth represents the whole texel, and the filter compares with texels at distances up to its reach. On a
// plane of slope m = tan(angle to the light) depth differs by m reach texels over that distance. Two biases cover this
// difference, each where it is reliable:
//
// The caster bias offsets the map by the exact plane of the rasterized triangle (shadow.frag), up to slope
// kShadowCasterSlope. It uses no normal, so a normal map cannot invalidate it. However, it does not include steeper
// faces adjacent to the triangle.
//
// The receiver bias moves the receiving point toward the light according to its own plane, up to slope kShadowSlope.
// The remainder moves the point along its normal (normal offset: Holbert 2011, Saying "Goodbye" to Shadow Acne, GDC),
// which is bounded where a slope is not. The normal is the shading normal, which every layout stores.

SH_CONST float kShadowCasterSlope = 1.0f;
SH_CONST float kShadowSlope = 2.0f;
// For surfaces that are not planar within a texel, and for rounding: texels.
SH_CONST float kShadowConstantBias = 0.5f;

// Reach of a filter from the point along each axis, texels. PCSS biases its wide kernels separately.
SH_FUNC float shadowReach(uint filterKind) {
  return filterKind == kShadowFilterHard ? 0.5f : 1.5f;
}

// Depth bias to add to a surface whose depth changes by (dx, dy) from one texel to the next. `unit` is the depth per
// texel on a plane of slope 1.
SH_FUNC float shadowCasterBias(float dx, float dy, float unit, uint filterKind) {
  float steepest = kShadowCasterSlope * 1.41421356f * unit;  // maximum of |dx| + |dy|
  return min(abs(dx) + abs(dy), steepest) * shadowReach(filterKind) + kShadowConstantBias * unit;
}

// Radius of a filter around the point, meters, for texels `width` meters wide.
SH_FUNC float shadowRadius(float width, uint filterKind) {
  return 1.41421356f * shadowReach(filterKind) * width;
}

// The components of a point's normal across the map's axis (x) and against the ray that reaches the point (y), where
// rays have length 1 along the axis. The slope of the point's plane is x / y.
SH_FUNC vec2 shadowSlope(ShadowMap m, vec3 n, vec3 toLight) {
  vec3 axis = vec3(m.away.x, m.away.y, m.away.z);
  float along = dot(n, axis);
  return vec2(sqrt(max(1.0f - along * along, 0.0f)), max(dot(n, toLight), 0.0f) / max(-dot(toLight, axis), 1e-3f));
}

// Receiver bias: depth to subtract from a point for the slope of its plane.
SH_FUNC float shadowReceiverBias(ShadowMap m, vec2 slope, float width, uint filterKind) {
  return min(slope.x / max(slope.y, 1e-3f), kShadowSlope) * shadowRadius(width, filterKind) * m.depthScale;
}

// Normal offset: meters to move a point along its normal for the slope beyond kShadowSlope.
SH_FUNC float shadowNormalOffset(vec2 slope, float width, uint filterKind) {
  return max(slope.x - kShadowSlope * slope.y, 0.0f) * shadowRadius(width, filterKind);
}

// --- lookup ---------------------------------------------------------------------------------------------------------

// The cube map face that a direction from the light falls in: +x, -x, +y, -y, +z, -z.
SH_FUNC uint shadowFace(vec3 d) {
  vec3 a = vec3(abs(d.x), abs(d.y), abs(d.z));
  if (a.x >= a.y && a.x >= a.z) return d.x >= 0.0f ? 0u : 1u;
  if (a.y >= a.z) return d.y >= 0.0f ? 2u : 3u;
  return d.z >= 0.0f ? 4u : 5u;
}

struct ShadowPoint {
  vec2 texel;   // relative to the first corner of its tile
  float depth;  // 0 to 1 within the map
  float away;   // meters along the map's axis
  float width;  // width of a texel there, meters
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

// True if the texel is in the tile, at least `room` texels from its edges.
SH_FUNC bool shadowInside(ShadowMap m, vec2 texel, float room) {
  return texel.x >= room && texel.y >= room && texel.x <= m.size - room && texel.y <= m.size - room;
}

// Weights of the quadratic B-spline for PCF, for the texel that contains a point and its two neighbors along an axis.
// The filter is 3 texels wide, smooth to its first derivative, and sums to 1. `offset` is the point's offset from that
// texel's center, -1/2 to 1/2.
SH_FUNC vec3 shadowWeights(float offset) {
  float before = 0.5f - offset, after = 0.5f + offset;
  return vec3(0.5f * before * before, 0.75f - offset * offset, 0.5f * after * after);
}

// Percentage-closer soft shadows (PCSS, Fernando 2005): taps of the blocker search and of the filter.
SH_CONST uint kShadowSearchTaps = 16u;
SH_CONST uint kShadowPcssTaps = 64u;
// Maximum radius of a kernel as a fraction of its tile.
SH_CONST float kShadowWidest = 0.125f;

// The i-th of n points distributed evenly over the unit disc (Vogel 1979): the golden angle apart, without random
// rotation.
SH_FUNC vec2 shadowTap(uint i, uint n) {
  float radius = sqrt((float(i) + 0.5f) / float(n)), angle = float(i) * 2.39996323f;
  return vec2(radius * cos(angle), radius * sin(angle));
}

// Penumbra radius in meters at the receiving point: the light seen through a hole at depth `blocker`. Both depths are
// meters along the axis.
SH_FUNC float shadowPenumbra(ShadowMap m, float receiver, float blocker) {
  float behind = max(receiver - blocker, 0.0f);
  return m.lightSize * (m.perspective > 0.5f ? behind / max(blocker, 1e-6f) : behind);
}

// Receiver plane bias: change of depth per texel across and down on the plane through the point, for kernels wider than
// the map's own bias covers. The slope is bounded: for a grazing plane, or a normal that is not the plane's, comparison
// depths must not move behind all surfaces.
SH_FUNC vec2 shadowPlane(ShadowMap m, vec3 n, vec3 toLight, float width) {
  vec3 right = vec3(m.across.x, m.across.y, m.across.z), down = vec3(m.down.x, m.down.y, m.down.z);
  vec3 axis = vec3(m.away.x, m.away.y, m.away.z);
  // In a perspective map the rows contain a component along the axis, which is removed.
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
