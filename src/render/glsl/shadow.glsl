// How much of a light reaches a surface, by its shadow maps. Depths are compared one by one, then the results are
// weighted: the same on every device and for every format, none of which but depth could be filtered.
#ifndef LATELIGHT_SHADOW_GLSL
#define LATELIGHT_SHADOW_GLSL
#include "render/glsl/lit_maps.glsl"
#include "render/glsl/setup.glsl"
#include "shared/shadow.h"
#include "shared/surface.h"
#include "shared/light.h"

// The maps of a light in a view, or none.
LightShadow lightShadow(FrameConstants frame, uint view, uint light) {
  ShadowBits bits = ShadowBitsRef(frame.shadowBits).v[light >> 5u];
  uint bit = 1u << (light & 31u);
  LightShadow found = LightShadow(0u, 0u, 0u);
  // A loop, since lavapipe runs a branch whether any lane takes it or not.
  for (bool some = (bits.lights & bit) != 0u; some; some = false) {
    uint column = bits.before + uint(bitCount(bits.lights & (bit - 1u)));
    found = LightShadowRef(frame.lightShadows).v[view * frame.shadowColumns + column];
  }
  return found;
}

bool shadowIsPacked() { return kShadowFormat == kShadowRgba8 || kShadowFormat == kShadowRgba8Classic; }

// Texels are counted from the first corner of the map's tile.
float shadowDepthAt(ShadowMap m, ivec2 texel) {
  vec4 t = texelFetch(shadowAtlas, ivec3(ivec2(m.corner) + texel, int(m.layer)), 0);
  if (kShadowFormat == kShadowRgba8) return unpackDepth(t);
  if (kShadowFormat == kShadowRgba8Classic) return unpackDepthClassic(t);
  return t.r;
}

float shadowLit(ShadowMap m, vec2 texel, float depth) {
  return shadowDepthAt(m, ivec2(texel)) >= depth ? 1.0 : 0.0;
}

// Which of the four texels around a corner of texels the light reaches; in the order of textureGather(): the two of the
// second row, then those of the first from right to left.
vec4 shadowCorner(ShadowMap m, ivec2 corner, float depth) {
  vec4 depths;
  if (shadowIsPacked()) {
    depths = vec4(shadowDepthAt(m, corner + ivec2(-1, 0)), shadowDepthAt(m, corner),
                  shadowDepthAt(m, corner + ivec2(0, -1)), shadowDepthAt(m, corner - 1));
  } else {
    vec2 place = vec2(ivec2(m.corner) + corner) / vec2(textureSize(shadowAtlas, 0).xy);
    depths = textureGather(shadowAtlas, vec3(place, float(m.layer)));
  }
  return vec4(greaterThanEqual(depths, vec4(depth)));
}

float shadowPcf(ShadowMap m, vec2 texel, float depth) {
  vec2 middle = floor(texel);
  vec2 offset = texel - middle - 0.5;
  vec3 across = shadowWeights(offset.x);
  ivec2 t = ivec2(middle);
  // By four corners, since a GPU gathers four texels in the time of one.
  vec4 a = shadowCorner(m, t, depth), b = shadowCorner(m, t + ivec2(1, 0), depth);
  vec4 c = shadowCorner(m, t + ivec2(0, 1), depth), d = shadowCorner(m, t + 1, depth);
  vec3 rows = vec3(dot(vec3(a.wz, b.z), across), dot(vec3(a.xy, b.y), across), dot(vec3(c.xy, d.y), across));
  return dot(rows, shadowWeights(offset.y));
}

vec2 shadowClamp(ShadowMap m, vec2 texel) { return clamp(texel, vec2(1.5), vec2(m.size - 1.5)); }

float shadowPcss(ShadowMap m, ShadowPoint p, vec2 plane) {
  float widest = kShadowWidest * m.size;
  float near = -m.depthOffset / m.depthScale;  // metres: where depth is 0
  float search = clamp(shadowPenumbra(m, p.away, near) / p.width, 1.5, widest);
  float blockers = 0.0, depths = 0.0;
  for (uint i = 0u; i < kShadowSearchTaps; ++i) {
    vec2 tap = shadowTap(i, kShadowSearchTaps) * search;
    float depth = shadowDepthAt(m, ivec2(shadowClamp(m, p.texel + tap)));
    bool blocks = depth < p.depth + dot(plane, tap);
    blockers += blocks ? 1.0 : 0.0;
    depths += blocks ? depth : 0.0;
  }
  float blocker = (depths / max(blockers, 1.0) - m.depthOffset) / m.depthScale;
  float radius = clamp(shadowPenumbra(m, p.away, blocker) / p.width, 1.5, widest);
  float lit = 0.0;
  for (uint i = 0u; i < kShadowPcssTaps; ++i) {
    vec2 tap = shadowTap(i, kShadowPcssTaps) * radius;
    lit += shadowLit(m, shadowClamp(m, p.texel + tap), p.depth + dot(plane, tap));
  }
  return blockers > 0.0 ? lit / float(kShadowPcssTaps) : 1.0;
}

// The finest map of a light that has the point and the filter's reach around it. False: none has. (One load for each
// map that is looked at: by address, which is expensive on lavapipe. And the condition stands before the load: what only the
// body of a loop defines, lavapipe 22.3 takes from the last round for lanes that left in an earlier one.)
bool findShadowMap(FrameConstants frame, Light light, LightShadow shadow, vec3 position, out ShadowMap m) {
  float room = shadowReach(kShadowFilter) + 0.5;
  bool directional = lightIsDirectional(light.type);
  bool cube = !directional && shadow.maps == 6u;
  uint next = shadow.first + (cube ? shadowFace(position - light.position) : 0u);
  uint end = directional ? shadow.first + shadow.maps : next + 1u;
  bool found = false;
  m = ShadowMap(vec4(0.0), vec4(0.0), vec4(0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, uvec2(0u), 0.0, 0u,
                uint[2](0u, 0u));
  while (!found && next < end) {
    m = frameShadowMap(frame, next);
    found = !directional || shadowInside(m, shadowPoint(m, position).texel, room);
    ++next;
  }
  return found;
}

// 1: all of it reaches the surface. By the maps of a light that has them.
float shadowByMaps(FrameConstants frame, Light light, LightShadow shadow, Surface s, vec3 toLight) {
  ShadowMap m;
  bool found = findShadowMap(frame, light, shadow, s.position, m);
  ShadowPoint p = shadowPoint(m, s.position);
  vec2 slope = shadowSlope(m, s.normal, toLight);
  p = shadowPoint(m, s.position + s.normal * shadowNormalOffset(slope, p.width, kShadowFilter));
  p.texel = shadowClamp(m, p.texel);
  p.depth -= m.depthSlack + shadowReceiverBias(m, slope, p.width, kShadowFilter);
  float lit;
  if (kShadowFilter == kShadowFilterPcss)
    lit = shadowPcss(m, p, shadowPlane(m, s.normal, toLight, p.width));
  else if (kShadowFilter == kShadowFilterPcf)
    lit = shadowPcf(m, p.texel, p.depth);
  else
    lit = shadowLit(m, p.texel, p.depth);
  return found && p.depth < 1.0 ? lit : 1.0;
}

// The same, from the G-buffer where it has been looked up already.
float shadowFactor(FrameConstants frame, Light light, LightShadow shadow, Surface s, vec3 toLight) {
#ifdef GBUFFER_SUN_TARGET
  if (kSunInGbuffer != 0u && shadow.sun != 0u) return s.sun;
#endif
  return shadowByMaps(frame, light, shadow, s, toLight);
}

#endif
