// The lobes of a path's surface: reflectance, and directions sampled in proportion to it.
#ifndef LATELIGHT_PATH_LOBES_GLSL
#define LATELIGHT_PATH_LOBES_GLSL
#include "render/glsl/rays.glsl"
#include "render/glsl/sobol.glsl"
#include "shared/shade.h"

struct PathVertex {
  Surface s;
  vec3 toEye;
  SurfaceBrdf brdf;
  float alpha;
  float specular;  // probability with which the specular lobe is sampled
  vec3 mirrored;   // fraction of uniform light that the specular lobe reflects
};

// The table of splitSum(), extrapolated to its borders, half a texel beyond the centers of the first and last texels.
vec2 extrapolatedSplitSum(Surface s, vec3 toEye) {
  float margin = 0.5 / float(textureSize(reflectanceTable, 0).x);
  vec2 at = vec2(clamp(dot(s.normal, toEye), 0.0, 1.0), s.roughness), within = clamp(at, margin, 1.0 - margin);
  return 2.0 * textureLod(reflectanceTable, within, 0.0).rg - textureLod(reflectanceTable, 2.0 * within - at, 0.0).rg;
}

PathVertex pathVertex(Surface s, vec3 toEye) {
  PathVertex v;
  SurfaceReflectance reflected = surfaceReflectance(s, extrapolatedSplitSum(s, toEye));
  s.scattered = reflected.scattered;
  v.mirrored = reflected.once;
  v.s = s;
  v.toEye = toEye;
  v.brdf = surfaceBrdf(s, toEye, pathShading());
  v.alpha = ggxAlpha(s.roughness);
  float mirrored = maxChannel(schlick(v.brdf.f0, v.brdf.f90, v.brdf.nv));
  float scattered = maxChannel(v.brdf.diffuse) * kPi;
  v.specular = clamp(mirrored / max(mirrored + scattered, 1e-6), 0.1, scattered > 0.0 ? 0.9 : 1.0);
  return v;
}

// The radiance toward the eye from radiance 1 in a direction, times the cosine.
vec3 pathReflectance(PathVertex v, vec3 toLight) {
  if (dot(v.s.geonormal, toLight) <= 0.0) return vec3(0.0);
  return shadeLight(v.brdf, LightSample(toLight, vec3(1.0), 1.0), pathShading());
}

// The fraction of pathReflectance() that the specular lobe reflects.
vec3 mirroredShare(PathVertex v, vec3 toLight) {
  SurfaceBrdf lobe = v.brdf;
  lobe.diffuse = vec3(0.0);
  LightSample light = LightSample(toLight, vec3(1.0), 1.0);
  return shadeLight(lobe, light, pathShading()) / max(shadeLight(v.brdf, light, pathShading()), vec3(1e-20));
}

// 1/sr: half of the microfacets' visible area is toward the eye (Heitz 2018, Sampling the GGX Distribution of Visible
// Normals, JCGT 7(4)).
float pathDensity(PathVertex v, vec3 toLight) {
  HalfAngles a = halfAngles(v.s.normal, toLight, v.toEye);
  float mirrored = ggxDistribution(a.nh, a.sin2, v.alpha) / (2.0 * (v.brdf.nv + smithRoot(v.brdf.nv, v.alpha * v.alpha)));
  float scattered = max(dot(v.s.normal, toLight), 0.0) * kInvPi;
  return mix(scattered, mirrored, v.specular);
}

vec3 sampleLobes(PathVertex v) {
  vec2 u = nextSample();
  float choice = nextSample().x;
  mat3 axes = rayAxes(v.s.normal);
  vec2 disk = diskSample(u);
  vec3 scattered = axes * vec3(disk, sqrt(max(1.0 - dot(disk, disk), 0.0)));
  // A visible normal, by a cap of the unit sphere (Dupuy and Benyoub 2023, Sampling Visible GGX Normals with Spherical
  // Caps).
  vec3 eye = v.toEye * axes;
  eye.z = max(eye.z, kMinNv);
  vec3 stretched = normalize(vec3(eye.xy * v.alpha, eye.z));
  float height = 1.0 - u.y * (1.0 + stretched.z), turn = 2.0 * kPi * u.x;
  vec3 cap = vec3(sqrt(max(1.0 - height * height, 0.0)) * vec2(cos(turn), sin(turn)), height) + stretched;
  vec3 facet = axes * normalize(vec3(cap.xy * v.alpha, max(cap.z, 1e-6)));
  vec3 mirrored = facet * (2.0 * dot(facet, v.toEye)) - v.toEye;
  return choice < v.specular ? mirrored : scattered;
}

#endif
