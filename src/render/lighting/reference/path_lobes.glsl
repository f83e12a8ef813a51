// The lobes of a path's surface: reflectance, and directions sampled in proportion to it. path_coats.glsl has those of
// surfaces with coats or transmission.
#ifndef LATELIGHT_PATH_LOBES_GLSL
#define LATELIGHT_PATH_LOBES_GLSL
#include "render/glsl/rays.glsl"
#include "render/lighting/reference/path_coats.glsl"
#include "shared/shade.h"

struct PathVertex {
  Surface s;
  vec3 toEye;
  SurfaceBrdf brdf;
  SurfaceBrdf lit;     // for lights, with `shading`
  uint shading;        // kShading*
  bool visible;        // the first surface of a path
  float alpha;
  float specular;      // probability with which the specular lobe is sampled
  vec3 mirrored;       // fraction of uniform light that the specular lobe reflects
  bool coated;         // `coats` replaces `brdf` and `specular`
  CoatedVertex coats;
};

// Lights follow --shading on visible surfaces, which are the first ones of paths.
PathVertex pathVertex(Surface s, vec3 toEye, bool visible) {
  PathVertex v;
  SurfaceReflectance reflected =
      surfaceReflectance(s, extrapolatedSplitSum(vec2(clamp(dot(s.normal, toEye), 0.0, 1.0), s.roughness)));
  s.scattered = reflected.scattered;
  v.mirrored = reflected.once;
  v.s = s;
  v.toEye = toEye;
  v.brdf = surfaceBrdf(s, toEye, pathShading());
  v.visible = visible;
  v.shading = visible ? kShading : pathShading();
  v.lit = v.brdf;
  if (kShading != pathShading() && visible) v.lit = surfaceBrdf(s, toEye, kShading);
  v.alpha = ggxAlpha(s.roughness);
  float mirrored = maxChannel(schlick(v.brdf.f0, v.brdf.f90, v.brdf.nv));
  float scattered = maxChannel(v.brdf.diffuse) * kPi;
  v.specular = max(mirrored / max(mirrored + scattered, 1e-6), 0.1);
  v.coated = false;
  return v;
}

// The radiance toward the eye from radiance 1 in a direction, times the cosine, of a surface with coats.
vec3 coatedLight(PathVertex v, vec3 toLight, bool isLight) {
  CoatedVertex coats = v.coats;
  if (kShading != pathShading() && isLight && v.visible) coats = withoutCompensation(coats, v.lit);
  return coatedReflectance(coats, v.s, v.toEye, toLight);
}

// The radiance toward the eye from a light, or from anything else.
vec3 reflectedLight(PathVertex v, LightSample light, bool isLight) {
  if (kLayers != 0u && v.coated) return coatedLight(v, light.toLight, isLight) * (light.intensity * light.attenuation);
  if (dot(v.s.geonormal, light.toLight) <= 0.0) return vec3(0.0);
  if (kShading == pathShading() || !isLight) return shadeLight(v.brdf, light, pathShading());
  return shadeLight(v.lit, light, v.shading);
}

// The radiance toward the eye from radiance 1 in a direction, times the cosine.
vec3 pathReflectance(PathVertex v, vec3 toLight, bool isLight) {
  return reflectedLight(v, LightSample(toLight, vec3(1.0), 1.0), isLight);
}

// The fraction of pathReflectance() that the specular lobe reflects.
vec3 mirroredShare(PathVertex v, vec3 toLight) {
  SurfaceBrdf lobe = v.brdf;
  lobe.diffuse = vec3(0.0);
  LightSample light = LightSample(toLight, vec3(1.0), 1.0);
  vec3 all = shadeLight(v.brdf, light, pathShading());
  return min(shadeLight(lobe, light, pathShading()) / max(all, vec3(1e-20)), vec3(1.0));  // the rest is not negative
}

// 1/sr: half of the microfacets' visible area is toward the eye (Heitz 2018, Sampling the GGX Distribution of Visible
// Normals, JCGT 7(4)).
float pathDensity(PathVertex v, vec3 toLight) {
  if (kLayers != 0u && v.coated) return coatedDensity(v.coats, v.s, v.toEye, toLight);
  HalfAngles a = halfAngles(v.s.normal, toLight, v.toEye);
  float root = smithRoot(v.brdf.nv, v.alpha * v.alpha);
  float mirrored = ggxDistribution(a.nh, a.sin2, v.alpha) / (2.0 * (v.brdf.nv + root));
  float scattered = max(dot(v.s.normal, toLight), 0.0) * kInvPi;
  return mix(scattered, mirrored, v.specular);
}

// Samples a direction. `choice`, in [0, 1), selects the lobe.
vec3 sampleLobes(PathVertex v, vec2 u, float choice) {
  if (kLayers != 0u && v.coated) return sampleCoats(v.coats, v.s, v.toEye, u, choice);
  StretchedFrame facets = roundFrame(v.s.normal, v.alpha);
  if (choice < v.specular) return mirroredBy(sampleFacet(facets, v.toEye, u), v.toEye);
  return cosineSample(facets.normal, u);
}

// Samples a direction by the next points of the path's sequence.
vec3 nextDirection(PathVertex v) {
  vec2 u = nextSample();
  return sampleLobes(v, u, nextSample().x);
}

#endif
