// The light of a point of a surface with layers, by every light and the environment. After what finds the point and its
// textures (surface_fragment.glsl, surface_point.glsl), with COATED. Lights come from the tree, where a shader has no lists
// of them.
#include "render/glsl/surface.glsl"
#include "shared/gbuffer.h"
#include "render/glsl/environment.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/tree_lights.glsl"
#include "render/layered/surface_layers.glsl"

struct LayeredPoint {
  Surface s;
  SurfaceLayers layers;
  vec3 toEye;
  vec3 emitted;  // before the coat
};

// Of a material without layers too: blended surfaces of both kinds are lit by one shader.
LayeredPoint layeredPoint(FrameConstants frame, uint view, Material m, SurfacePoint p) {
  LayeredPoint point;
  point.s = evaluateMaterial(frame, m, p);
  point.layers = emptyLayers();
  if ((m.flags & kMaterialLayered) != 0u) point.layers = evaluateLayers(frame, m, p, point.s);
  point.s.flags &= ~kSurfaceLayered;
  point.emitted = emittedRadiance(point.s);
  point.s = litSurface(point.s);
  point.toEye = directionToEye(frameView(frame, view), point.s.position);
  return point;
}

LayeredBrdf layeredBrdfAt(LayeredPoint point) {
  LayerTables t = layerTablePlaces(point.s, point.layers, point.toEye);
  t.base = textureLod(reflectanceTable, t.base, 0.0).rg;
  if (point.layers.clearcoat > 0.0) t.coat = textureLod(reflectanceTable, t.coat, 0.0).rg;
  if (kShading == kShadingGgxCompensated && point.layers.transmission > 0.0)
    t.behind = textureLod(reflectanceTable, t.behind, 0.0).rg;
  return layeredBrdf(point.s, point.layers, point.toEye, kShading, t);
}

vec3 roundLobeLight(FrameConstants frame, vec3 normal, vec3 toEye, float roughness) {
  return environmentLobe(frame, normal, toEye, roughness, environmentDiffuseAt(frame, normal));
}

vec3 stretchedLobeLight(FrameConstants frame, inout LayeredBrdf b) {
  FilmCurve film = filmCurve(b);
  StretchedSum sum = emptySum();
  for (uint i = 0u; i < kStretchedSamples; ++i) {
    LobeSample r = baseSample(b, i);
    addSample(sum, b, film, r, environmentLevel(frame, r.toLight, levelOfShare(r.solidAngle)));
  }
  return meanOfSum(b, sum);
}

vec3 sheenLobeLight(FrameConstants frame, LayeredBrdf b) {
  vec3 along = alongEye(b.base.normal, b.base.toEye), sum = vec3(0.0);
  float weights = 0.0, level = levelOfShare(kSheenSolidAngle);
  for (uint i = 0u; i < kSheenSamples; ++i) {
    SheenSample r = sheenSample(b.base.normal, along, b.base.toEye, b.base.nv, b.layers.sheenRoughness, i);
    sum += environmentLevel(frame, r.toLight, level) * r.weight;
    weights += r.weight;
  }
  return sum / max(weights, 1.0e-20);
}

vec3 layeredEnvironment(FrameConstants frame, inout LayeredBrdf b, vec3 toEye) {
  if (!hasEnvironment(frame)) return vec3(0.0);
  SurfaceLayers l = b.layers;
  LayerLight found;
  found.front = environmentDiffuseAt(frame, b.base.normal);
  found.back = l.diffuseTransmission > 0.0 ? environmentDiffuseAt(frame, -b.base.normal) : vec3(0.0);
  found.sheen = maxChannel(l.sheenColor) > 0.0 ? sheenLobeLight(frame, b) : vec3(0.0);
  found.base = l.anisotropy > 0.0 ? stretchedLobeLight(frame, b)
                                  : environmentLobe(frame, b.base.normal, toEye, b.surface.roughness, found.front);
  found.coat = l.clearcoat > 0.0 ? roundLobeLight(frame, l.clearcoatNormal, toEye, saturate(l.clearcoatRoughness))
                                 : vec3(0.0);
  return shadeLayeredEnvironment(b, found) * frame.environmentIntensity;
}

// Radiance that all lights send to the eye, by the tree. Every invocation of the subgroup must call it, for the same view;
// `shows` is false for those without a point. `plain`: without subgroups.
vec3 lightsAtPoint(FrameConstants frame, uint view, LayeredPoint point, LayeredBrdf brdf, bool shows, bool plain) {
  if (plain) return shadeAllLightsPlainly(frame, view, point.s, brdf);
  return shadeAllByTree(frame, view, point.s, brdf, shows);
}

// Radiance times exposure, of what lights and the environment send to the eye, and what is emitted.
vec3 exposedRadiance(FrameConstants frame, LayeredPoint point, LayeredBrdf brdf, vec3 radiance) {
  vec3 emitted = coatedEmission(brdf, min(point.emitted * frame.exposure, vec3(65504.0)));
  return min(emitted + radiance * frame.exposure, vec3(65504.0));
}
