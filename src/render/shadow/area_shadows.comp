#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// Adds the light of area lights whose shadows rays find. Rays to points of the shape estimate the fraction of its
// reflected light that is not blocked, and this fraction multiplies the light without shadows, which has no noise
// (Heitz, Hill and McGuire 2018, Combining Analytic Direct Illumination and Stochastic Shadows). The Lambertian part
// and the specular lobe have fractions of their own. Inputs: the G-buffer, FrameConstants::areaShadows and the scene's
// BVHs. Output: lightTarget. The lighting technique has added all other light before.
#define ONE_SAMPLE
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/ray_samples.glsl"
#include "render/glsl/rays.glsl"
#include "render/shadow/area_shadows_push.h"
#include "shared/area_samples.h"

layout(push_constant, scalar) uniform Push { AreaShadowsPush push; };
#include "render/shadow/light_sums.glsl"

// The reflected light of sampled points through both lobes, and the part of it that is not blocked.
struct ShadowSum {
  float scattered, mirrored, litScattered, litMirrored;
};

void addRay(inout ShadowSum sum, FrameConstants frame, View view, SurfaceBrdf brdf, AreaLight light, Surface s, vec2 u) {
  vec3 origin = s.position + s.normal * rayOffset(s.position, distance(s.position, view.eye));
  AreaSample point = sampleArea(light, origin, u);
  if (point.density <= 0.0) return;
  LightSample arriving = LightSample(point.toLight, vec3(1.0), 1.0 / point.density);
  SurfaceBrdf lobe = brdf;
  lobe.diffuse = vec3(0.0);
  float all = luminance(shadeLight(brdf, arriving, kShading)), mirrored = luminance(shadeLight(lobe, arriving, kShading));
  float scattered = max(all - mirrored, 0.0);
  if (all <= 0.0) return;
  float far = max(point.distance - rayOffset(light.center, point.distance), 0.0);
  float lit = isBlocked(frame, Ray(origin, vec3(0.0), point.toLight, 0.0, far)) ? 0.0 : 1.0;
  sum.scattered += scattered;
  sum.mirrored += mirrored;
  sum.litScattered += scattered * lit;
  sum.litMirrored += mirrored * lit;
}

vec3 shadowedLight(FrameConstants frame, View view, SurfaceBrdf brdf, AreaLobes lobes, AreaLight light, Surface s) {
  AreaReflection r = reflectArea(brdf, lobes, light, s.position, kShading);
  if (maxChannel(r.scattered + r.mirrored) <= 0.0) return vec3(0.0);
  vec2 start = raySeed(s.position);
  ShadowSum sum = ShadowSum(0.0, 0.0, 0.0, 0.0);
  uint i = 0u;
  do {  // tested at the end, here and below, because lavapipe would execute the body once more
    addRay(sum, frame, view, brdf, light, s, raySample(start, i));
  } while (++i < push.rays);
  return r.scattered * (sum.litScattered / max(sum.scattered, 1e-30)) +
         r.mirrored * (sum.litMirrored / max(sum.mirrored, 1e-30));
}

// Returns `radiance` plus that of the lights of this pass.
vec3 lightsAt(FrameConstants frame, View view, LitPixel p, vec3 radiance) {
  SurfaceBrdf brdf = surfaceBrdf(p.s, p.toEye, kShading);
  AreaLobes lobes = surfaceLobes(frame, p.s, brdf);
  uint i = push.first;
  do {
    if (hasRayShadows(frame, i)) radiance += shadowedLight(frame, view, brdf, lobes, frameAreaLight(frame, i), p.s);
  } while (++i < push.end);
  return radiance;
}

void main() {
  bindSurfaces(push.frame, push.shown);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  ivec3 place = ownPixel();
  View view = frameView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  LitPixel p = readPixel(frame, view, place, inside ? 1u : 0u);
  if (!inside || !p.lit || p.shadedSeparately || !reflects(p.s)) return;
  addLight(frame, place, lightsAt(frame, view, p, lightBefore(place)));
}
