// How much of a light reaches a surface, by its shadow maps. Depths are fetched and compared one by one, then the
// results are weighted: the same on every device and for every format, none of which but depth could be filtered.
#ifndef LATELIGHT_SHADOW_GLSL
#define LATELIGHT_SHADOW_GLSL
#include "render/glsl/lit_maps.glsl"
#include "render/glsl/setup.glsl"
#include "shared/shadow.h"
#include "shared/surface.h"

float shadowDepthAt(ivec2 texel) {
  vec4 t = texelFetch(shadowAtlas, texel, 0);
  if (kShadowFormat == kShadowRgba8) return unpackDepth(t);
  if (kShadowFormat == kShadowRgba8Classic) return unpackDepthClassic(t);
  return t.r;
}

float shadowLit(vec2 texel, float depth) { return shadowDepthAt(ivec2(floor(texel))) >= depth ? 1.0 : 0.0; }

float shadowRow(ivec2 texel, float depth, vec3 weights) {
  vec3 lit = vec3(shadowDepthAt(texel + ivec2(-1, 0)) >= depth, shadowDepthAt(texel) >= depth,
                  shadowDepthAt(texel + ivec2(1, 0)) >= depth);
  return dot(lit, weights);
}

float shadowPcf(vec2 texel, float depth) {
  vec2 middle = floor(texel);
  vec2 offset = texel - middle - 0.5;
  vec3 across = shadowWeights(offset.x);
  ivec2 t = ivec2(middle);
  vec3 rows = vec3(shadowRow(t + ivec2(0, -1), depth, across), shadowRow(t, depth, across),
                   shadowRow(t + ivec2(0, 1), depth, across));
  return dot(rows, shadowWeights(offset.y));
}

vec2 shadowClamp(ShadowMap m, vec2 texel) { return clamp(texel, m.low + 1.5, m.low + m.size - 1.5); }

float shadowPcss(ShadowMap m, ShadowPoint p, vec2 plane) {
  float widest = kShadowWidest * m.size;
  float near = -m.depthOffset / m.depthScale;  // metres: where depth is 0
  float search = clamp(shadowPenumbra(m, p.away, near) / p.width, 1.5, widest);
  float blockers = 0.0, depths = 0.0;
  for (uint i = 0u; i < kShadowSearchTaps; ++i) {
    vec2 tap = shadowTap(i, kShadowSearchTaps) * search;
    float depth = shadowDepthAt(ivec2(shadowClamp(m, p.texel + tap)));
    bool blocks = depth < p.depth + dot(plane, tap);
    blockers += blocks ? 1.0 : 0.0;
    depths += blocks ? depth : 0.0;
  }
  float blocker = (depths / max(blockers, 1.0) - m.depthOffset) / m.depthScale;
  float radius = clamp(shadowPenumbra(m, p.away, blocker) / p.width, 1.5, widest);
  float lit = 0.0;
  for (uint i = 0u; i < kShadowPcssTaps; ++i) {
    vec2 tap = shadowTap(i, kShadowPcssTaps) * radius;
    lit += shadowLit(shadowClamp(m, p.texel + tap), p.depth + dot(plane, tap));
  }
  return blockers > 0.0 ? lit / float(kShadowPcssTaps) : 1.0;
}

// The finest map of a light that has the point and the filter's reach around it. False: none has. (One load for each
// map that is looked at: by address, and so dear on lavapipe. And the condition stands before the load: what only the
// body of a loop defines, lavapipe 22.3 takes from the last round for lanes that left in an earlier one.)
bool findShadowMap(Light light, vec3 position, out ShadowMap m) {
  ShadowMapRef maps = ShadowMapRef(packUint2x32(light.shadow & uvec2(~(kShadowSun | kShadowCube), ~0u)));
  float room = shadowReach(kShadowFilter) + 0.5;
  bool directional = light.type == kLightDirectional;
  uint next = (light.shadow.x & kShadowCube) != 0u ? shadowFace(position - light.position) : 0u;
  uint end = next + 1u;
  bool found = false;
  m = ShadowMap(vec4(0.0), vec4(0.0), vec4(0.0), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, vec2(0.0), 0.0, 0u);
  while (!found && next < end) {
    m = maps.v[next];
    found = !directional || shadowInside(m, shadowPoint(m, position).texel, room);
    end = directional ? m.maps : end;
    ++next;
  }
  return found;
}

// 1: all of it reaches the surface. By the maps of a light that has them.
float shadowByMaps(Light light, Surface s, vec3 toLight) {
  ShadowMap m;
  bool found = findShadowMap(light, s.position, m);
  ShadowPoint p = shadowPoint(m, s.position);
  vec2 slope = shadowSlope(m, s.normal, toLight);
  p = shadowPoint(m, s.position + s.normal * shadowNormalOffset(slope, p.width, kShadowFilter));
  p.texel = shadowClamp(m, p.texel);
  p.depth -= m.depthSlack + shadowReceiverBias(m, slope, p.width, kShadowFilter);
  float lit;
  if (kShadowFilter == kShadowFilterPcss)
    lit = shadowPcss(m, p, shadowPlane(m, s.normal, toLight, p.width));
  else if (kShadowFilter == kShadowFilterPcf)
    lit = shadowPcf(p.texel, p.depth);
  else
    lit = shadowLit(p.texel, p.depth);
  return found && p.depth < 1.0 ? lit : 1.0;
}

// The same, from the G-buffer where it has been looked up already.
float shadowFactor(Light light, Surface s, vec3 toLight) {
#ifdef GBUFFER_SUN_TARGET
  if (kSunInGbuffer && (light.shadow.x & kShadowSun) != 0u) return s.sun;
#endif
  return shadowByMaps(light, s, toLight);
}

#endif
