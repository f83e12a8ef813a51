// Shadow mapping: the fraction of a light that reaches a surface, with a single comparison, PCF or PCSS. Depths are
// compared before they are filtered, so the result is the same on every device and for every format; only depth formats
// could be filtered by hardware.
#ifndef LATELIGHT_SHADOW_GLSL
#define LATELIGHT_SHADOW_GLSL
#include "render/glsl/lit_maps.glsl"
#include "render/glsl/setup.glsl"
#include "shared/shadow.h"
#include "shared/surface.h"
#include "shared/light.h"

// Returns the shadow maps of a light in a view, or none.
LightShadow lightShadow(FrameConstants frame, uint view, uint light) {
  ShadowBits bits = ShadowBitsRef(frame.shadowBits).v[light >> 5u];
  uint bit = 1u << (light & 31u);
  LightShadow found = LightShadow(0u, 0u, 0u);
  if ((bits.lights & bit) != 0u) {
    uint column = bits.before + uint(bitCount(bits.lights & (bit - 1u)));
    found = LightShadowRef(frame.lightShadows).v[view * frame.shadowColumns + column];
  }
  return found;
}

bool shadowIsPacked() { return kShadowFormat == kShadowRgba8 || kShadowFormat == kShadowRgba8Classic; }

// Texel coordinates are relative to the first corner of the map's tile.
float shadowDepthAt(ShadowMap m, ivec2 texel) {
  vec4 t = texelFetch(shadowAtlas, ivec3(ivec2(m.corner) + texel, int(m.layer)), 0);
  if (kShadowFormat == kShadowRgba8) return unpackDepth(t);
  if (kShadowFormat == kShadowRgba8Classic) return unpackDepthClassic(t);
  return t.r;
}

float shadowLit(ShadowMap m, vec2 texel, float depth) {
  return shadowDepthAt(m, ivec2(texel)) >= depth ? 1.0 : 0.0;
}

// Compares the four texels around a texel corner; 1 is lit. The order is that of textureGather(): the second row from
// left to right, then the first row from right to left.
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
  // Four gathers, since a GPU gathers four texels in the time of one.
  vec4 a = shadowCorner(m, t, depth), b = shadowCorner(m, t + ivec2(1, 0), depth);
  vec4 c = shadowCorner(m, t + ivec2(0, 1), depth), d = shadowCorner(m, t + 1, depth);
  vec3 rows = vec3(dot(vec3(a.wz, b.z), across), dot(vec3(a.xy, b.y), across), dot(vec3(c.xy, d.y), across));
  return dot(rows, shadowWeights(offset.y));
}

vec2 shadowClamp(ShadowMap m, vec2 texel) { return clamp(texel, vec2(1.5), vec2(m.size - 1.5)); }

float shadowPcss(ShadowMap m, ShadowPoint p, vec2 plane) {
  float widest = kShadowWidest * m.size;
  float near = -m.depthOffset / m.depthScale;  // meters: where depth is 0
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

// Finds the finest map of a light that contains the point and the filter's footprint around it. Returns false if there
// is none. (There is one load per tested map, because loads by address are expensive on lavapipe. The condition
// precedes the load: for lanes that left the loop earlier, lavapipe returns the last iteration's value of
// variables that only the loop body defines.)
bool findShadowMap(FrameConstants frame, Light light, LightShadow shadow, vec3 position, out ShadowMap m) {
  float margin = shadowReach(kShadowFilter) + 0.5;
  bool directional = lightIsDirectional(light.type);
  bool cube = !directional && shadow.maps == 6u;
  uint next = shadow.first + (cube ? shadowFace(position - light.position) : 0u);
  uint end = directional ? shadow.first + shadow.maps : next + 1u;
  bool found = false;
  m = ShadowMap(vec4(0.0), vec4(0.0), vec4(0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, uvec2(0u), 0.0, 0u,
                uint[2](0u, 0u));
  while (!found && next < end) {
    m = frameShadowMap(frame, next);
    found = !directional || shadowInside(m, shadowPoint(m, position).texel, margin);
    ++next;
  }
  return found;
}

// Returns the lit fraction (1: fully lit) from the maps of a light that has shadow maps.
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

// As shadowByMaps(), but reads the sun's shadow from the G-buffer if it is stored there.
float shadowFactor(FrameConstants frame, Light light, LightShadow shadow, Surface s, vec3 toLight) {
#ifdef GBUFFER_SUN_TARGET
  if (kSunInGbuffer != 0u && shadow.sun != 0u) return s.sun;
#endif
  return shadowByMaps(frame, light, shadow, s, toLight);
}

#endif
