// Light of area lights without shadows. Every surface is shaded with all of them, because they are few
// (kMaxAreaLights). Include after environment.glsl.
#ifndef LATELIGHT_AREA_LIGHTS_GLSL
#define LATELIGHT_AREA_LIGHTS_GLSL
#include "load/AreaLight.glsl"
#include "render/glsl/setup.glsl"
#include "shared/shade_area.h"

AreaLight frameAreaLight(FrameConstants frame, uint index) {
  return loadAreaLight(frame.areaLights + uint64_t(index) * kAreaLightBytes);
}

// Returns true if rays find the light's shadows.
bool hasRayShadows(FrameConstants frame, uint index) {
  return (frame.areaShadows[index / 32u] >> (index % 32u) & 1u) != 0u;
}

// Returns the fitted lobe, interpolated in the table.
LtcFit lobeFit(FrameConstants frame, float nv, float roughness) {
  float last = float(kLtcSize - 1u);
  float row = clamp(roughness, 0.0, 1.0) * last, column = sqrt(clamp(1.0 - nv, 0.0, 1.0)) * last;
  uint low = min(uint(row), kLtcSize - 2u), left = min(uint(column), kLtcSize - 2u), at = low * kLtcSize + left;
  vec4 a = mix(sceneFloatsAt(frame.ltcTable, at), sceneFloatsAt(frame.ltcTable, at + 1u), column - float(left));
  vec4 b = mix(sceneFloatsAt(frame.ltcTable, at + kLtcSize), sceneFloatsAt(frame.ltcTable, at + kLtcSize + 1u),
               column - float(left));
  vec4 m = mix(a, b, row - float(low));
  return LtcFit(m.x, m.y, m.z, m.w);
}
LobeAxes lobeAxes(FrameConstants frame, vec3 normal, vec3 toEye, float roughness) {
  return fittedAxes(normal, toEye, lobeFit(frame, dot(normal, toEye), roughness));
}

AreaLobes surfaceLobes(FrameConstants frame, Surface s, SurfaceBrdf brdf) {
  vec2 table = splitSum(s, brdf.toEye);
  return areaLobes(brdf, surfaceReflectance(s, table).once, table, lobeFit(frame, brdf.nv, s.roughness), kShading);
}

// Returns the radiance that a surface reflects toward the eye from area lights, after prepareForLights(). A
// specialization constant comes first, because lavapipe executes both sides of a branch.
vec3 areaLight(FrameConstants frame, Surface s, vec3 toEye) {
  if (kAreaLights == kAreaLightsNone || frame.areaLightCount == 0u) return vec3(0.0);
  SurfaceBrdf brdf = surfaceBrdf(s, toEye, kShading);
  AreaLobes lobes = surfaceLobes(frame, s, brdf);
  vec3 radiance = vec3(0.0);
  uint i = 0u;
  do {
    if (kAreaLights != kAreaLightsUnshadowed || !hasRayShadows(frame, i))
      radiance += shadeArea(brdf, lobes, frameAreaLight(frame, i), s.position, kShading);
  } while (++i < frame.areaLightCount);
  return radiance;
}

#ifdef COATED
LayeredAreaLobes layeredLobes(FrameConstants frame, LayeredBrdf b) {
  Surface s = b.surface;
  LayeredAreaLobes lobes;
  lobes.base = areaLobes(b.base, b.once, splitSum(s, b.base.toEye), lobeFit(frame, b.base.nv, s.roughness), kShading);
  lobes.coat = lobes.base.mirror;
  if (b.layers.clearcoat > 0.0)
    lobes.coat = lobeAxes(frame, b.layers.clearcoatNormal, b.base.toEye, saturate(b.layers.clearcoatRoughness));
  lobes.back = cosineAxes(-s.normal);
  lobes.through = lobes.back;
  lobes.throughAlbedo = 0.0;
  if (b.layers.transmission > 0.0) {
    float roughness = transmittedRoughness(s.roughness, b.layers.ior);
    vec3 eye = eyeBehind(b);
    lobes.through = lobeAxes(frame, -s.normal, eye, roughness);
    vec2 table = textureLod(reflectanceTable, vec2(saturate(dot(-s.normal, eye)), roughness), 0.0).rg;
    lobes.throughAlbedo = table.x + table.y;
  }
  return lobes;
}

// As areaLight(), for a surface with coats.
vec3 layeredAreaLight(FrameConstants frame, LayeredBrdf b) {
  if (kAreaLights == kAreaLightsNone || frame.areaLightCount == 0u) return vec3(0.0);
  LayeredAreaLobes lobes = layeredLobes(frame, b);
  vec3 radiance = vec3(0.0);
  uint i = 0u;
  do {
    radiance += shadeLayeredArea(b, lobes, frameAreaLight(frame, i), kShading);
  } while (++i < frame.areaLightCount);
  return radiance;
}
#endif

#endif
