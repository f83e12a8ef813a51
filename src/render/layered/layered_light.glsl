// Shading of a point with a layered material (coats over a base surface, shared/layers.h) by all lights and the
// environment. Include after surface_fragment.glsl or surface_point.glsl, which provide the point and its textures,
// with COATED defined. Lights come from the light tree, unless the shader uses light lists.
#include "render/glsl/surface.glsl"
#include "shared/gbuffer.h"
#include "render/glsl/environment.glsl"
#include "render/glsl/area_lights.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/tree_lights.glsl"
#include "render/layered/surface_layers.glsl"

struct LayeredPoint {
  Surface s;
  SurfaceLayers layers;
  vec3 toEye;
  vec3 emitted;  // before attenuation by coats
};

// Evaluates the material at a point. Materials without coats are accepted as well, because one shader lights blended
// surfaces of both kinds.
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
  LayerTables t = layerTableCoordinates(point.s, point.layers, point.toEye);
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

// Returns the radiance from all lights toward the eye, found with the light tree. Every invocation of the subgroup must
// call it, for the same view; `shows` is false for those without a point. If `plain`, it loops over all lights without
// subgroup operations.
vec3 lightsAtPoint(FrameConstants frame, uint view, LayeredPoint point, LayeredBrdf brdf, bool shows, bool plain) {
  if (plain) return shadeAllLightsPlainly(frame, view, point.s, brdf);
  return shadeAllByTree(frame, view, point.s, brdf, shows);
}

// Returns the sum of emitted radiance and `radiance`, which is that from lights and the environment, times exposure.
vec3 exposedRadiance(FrameConstants frame, LayeredPoint point, LayeredBrdf brdf, vec3 radiance) {
  vec3 emitted = coatedEmission(brdf, min(point.emitted * frame.exposure, vec3(65504.0)));
  return min(emitted + radiance * frame.exposure, vec3(65504.0));
}
