#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// Path tracing from the visible surface of each pixel (Kajiya 1986, The Rendering Equation). At each surface, one
// light, one direction of the environment, one point of the emissive surfaces and one of the area lights are sampled,
// and the path goes on in a direction of the surface's lobes, which also finds the last three. From the fourth surface
// on, paths end at random in proportion to what they still carry (Russian roulette).
//
// Inputs: the G-buffer, the scene's BVHs and emitters (FrameConstants::rayScene), the environment's image and cells.
// `pathSum` accumulates the radiance over several passes. The last pass writes the lit picture: with kPathsFromLights,
// all light; otherwise it adds to the picture of another technique, and replaces that technique's light of the
// environment, which nothing blocks. The technique adds no light of area lights then.
//
// With kFiltered, `pathSum` holds light through the Lambertian lobe and `mirroredSum` light through the specular lobe.
// Both are divided by the albedos of these lobes, and w sums the squares of the samples' luminances. The last pass
// writes the inputs of indirect_filter.glsl.
#define ONE_SAMPLE
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/ray_point.glsl"  // after gbuffer_read.glsl, which may define sampleTexture()
#include "render/glsl/sobol.glsl"
#include "render/glsl/surface.glsl"
#include "render/lighting/reference/paths_push.h"

layout(push_constant, scalar) uniform Push { PathsPush push; };
layout(constant_id = kPathsFromLightsConstant) const uint kPathsFromLights = 0;
layout(constant_id = kFilteredConstant) const uint kFiltered = 0;
layout(constant_id = kEmittersConstant) const uint kEmitters = 0;  // 1: the scene has emissive surfaces
layout(constant_id = kSampledAreaLightsConstant) const uint kSampledAreaLights = 0;  // 1: the scene has area lights

layout(set = 0, binding = AFTER_LIT_MAPS) uniform sampler2D environmentPicture;
layout(set = 0, binding = AFTER_LIT_MAPS + 1, rgba32f) uniform image2DArray pathSum;
layout(set = 0, binding = AFTER_LIT_MAPS + 2, rgba32f) uniform image2DArray mirroredSum;
layout(set = 0, binding = AFTER_LIT_MAPS + 3, rgba32ui) uniform writeonly uimage2DArray filterGuide;
layout(set = 0, binding = AFTER_LIT_MAPS + 4, rgba16f) uniform writeonly image2DArray scatteredAlbedo;
layout(set = 0, binding = AFTER_LIT_MAPS + 5, rgba16f) uniform writeonly image2DArray mirroredAlbedo;

// Environment light and light between surfaces include multiple reflections between facets, as prefiltered environments
// do.
uint pathShading() { return kShading == kShadingBlinnPhong ? kShadingBlinnPhong : kShadingGgxCompensated; }

uint pathSeed;   // of the pixel
uint pathIndex;  // number of the sample
uint pathPair;   // the next pair of dimensions
vec2 nextSample() { return sobolSample(pathIndex, pathPair++, pathSeed); }

#include "render/lighting/reference/path_lights.glsl"

// Radiance toward the eye through both lobes of the visible surface; without kFiltered, `scattered` holds all of it.
struct PathLight {
  vec3 scattered, mirrored;
};

// `share`: the fraction that the specular lobe reflects.
void add(inout PathLight sum, vec3 radiance, vec3 share) {
  sum.scattered += radiance * (1.0 - share);
  sum.mirrored += radiance * share;
}
vec3 lobeShare(PathVertex v, vec3 toLight) { return kFiltered != 0u ? mirroredShare(v, toLight) : vec3(0.0); }

// Adds the light that the surface of a path receives directly. `share` is that of the visible surface for the path.
void addDirectLight(inout PathLight sum, FrameConstants frame, RayScene scene, PathVertex v, uint bounce, vec3 carried,
                    vec3 share, float distance) {
  vec3 origin = rayOrigin(v.s, distance);
  SurfaceBrdf brdf = v.brdf;
  uint shading = pathShading();
  if (bounce == 0u) {
    brdf = surfaceBrdf(v.s, v.toEye, kShading);
    shading = kShading;
  }
  LightRay sky = rayToSky(frame, scene, v), lit = noLightRay(), emitted = noLightRay(), area = noLightRay();
  if (bounce > 0u || kPathsFromLights != 0u) lit = rayToLight(frame, v, brdf, shading, origin);
  if (bounce < push.bounces) emitted = rayToEmitter(frame, scene, v, origin);
  if (hasAreaLights(frame)) area = rayToArea(frame, v, brdf, shading, origin);
  const uint kinds = kSampledAreaLights != 0u ? 4u : 3u;
  for (uint i = 0u; i < kinds; ++i) {  // one copy of the traversal
    LightRay light = i == 0u ? sky : (i == 1u ? lit : (i == 2u ? emitted : area));
    bool some = maxChannel(light.radiance) > 0.0;
    if (some) some = !isBlocked(frame, Ray(origin, vec3(0.0), light.toLight, 0.0, light.far));
    if (some) add(sum, carried * light.radiance, bounce == 0u ? lobeShare(v, light.toLight) : share);
  }
}

PathLight pathLight(FrameConstants frame, PathVertex v, float fromEye) {
  RayScene scene = RaySceneRef(frame.rayScene).v;
  PathLight sum = PathLight(vec3(0.0), vec3(0.0));
  vec3 carried = vec3(1.0), share = vec3(0.0);
  float distance = fromEye;
  bool goesOn = true;
  for (uint bounce = 0u; goesOn && bounce <= push.bounces; ++bounce) {
    addDirectLight(sum, frame, scene, v, bounce, carried, share, distance);
    vec3 toLight = sampleLobes(v);
    float density = pathDensity(v, toLight);
    if (bounce == 0u) share = lobeShare(v, toLight);
    vec3 fromArea = vec3(0.0);  // as `carried`, for light of area lights
    if (hasAreaLights(frame)) fromArea = carried * areaReflectance(v, toLight, bounce) / max(density, 1e-30);
    carried *= pathReflectance(v, toLight) / max(density, 1e-30);
    float left = maxChannel(carried), survives = bounce < 3u ? 1.0 : min(left, 0.95);
    goesOn = left > 0.0 && density > 0.0 && nextSample().x < survives;
    if (!goesOn) continue;
    carried /= survives;
    fromArea /= survives;
    Ray ray = Ray(rayOrigin(v.s, distance), vec3(0.0), toLight, 0.0, 3.0e38);
    RayHit hit = traceRay(frame, ray, kRayTwoSided);
    if (hasAreaLights(frame))
      add(sum, fromArea * areaRadiance(frame, ray, isHit(hit) ? hit.distance : 3.0e38, density), share);
    goesOn = isHit(hit) && bounce < push.bounces;
    if (!isHit(hit) && hasCells(scene, frame))
      add(sum, carried * skyRadiance(frame, toLight) * (density / (density + skyDensity(frame, scene, toLight))), share);
    if (!goesOn) continue;
    PathHit at = surfaceAt(frame, ray, hit);
    add(sum, carried * at.s.emissive * (density / (density + emitterDensity(scene, hit, at, toLight))), share);
    distance = hit.distance;
    v = pathVertex(at.s, -toLight);
  }
  return sum;
}

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) { return vec3(0.0); }

// The albedos by which light through the lobes of a surface is divided.
PathLight albedosOf(PathVertex v) { return PathLight(max(v.s.scattered, vec3(1e-3)), max(v.mirrored, vec3(1e-3))); }

// Returns the mean of the samples, and the variance of its luminance.
vec4 meanOf(vec4 sum) {
  float count = float(push.samples);
  vec3 mean = sum.rgb / count;
  float spread = max(sum.w / count - luminance(mean) * luminance(mean), 0.0);
  return vec4(mean, spread / max(count - 1.0, 1.0));
}

// Writes the inputs of the filter, and takes the light that it replaces out of the picture.
void writeForFilter(FrameConstants frame, ivec3 place, LitPixel p, PathVertex v, vec4 scattered, vec4 mirrored, bool lit) {
  PathLight albedos = albedosOf(v);
  imageStore(pathSum, place, meanOf(scattered));
  imageStore(mirroredSum, place, meanOf(mirrored));
  uint normal = packSnorm2x16(octahedralFromDirection(p.s.normal));
  imageStore(filterGuide, place, lit ? uvec4(floatBitsToUint(p.s.position), normal) : uvec4(0u));
  imageStore(scatteredAlbedo, place, vec4(albedos.scattered, p.s.roughness));
  imageStore(mirroredAlbedo, place, vec4(albedos.mirrored, lit ? 1.0 : 0.0));
  if (lit) imageStore(lightTarget, place, imageLoad(lightTarget, place) - vec4(p.radiance * frame.exposure, 0.0));
}

void main() {
  bindSurfaces(push.frame, push.shown);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  bindRayTextures(frame);
  ivec3 place = ownPixel();
  View view = frameView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  LitPixel p = readPixel(frame, view, place, inside ? 1u : 0u);
  if (!inside) return;
  if (kPathsFromLights != 0u) writeCounts(place, p.lit, vec4(0.0));
  bool lit = p.lit && !p.shadedSeparately && reflects(p.s);
  vec4 scattered = push.first > 0u ? imageLoad(pathSum, place) : vec4(0.0);
  vec4 mirrored = push.first > 0u && kFiltered != 0u ? imageLoad(mirroredSum, place) : vec4(0.0);
#ifndef GBUFFER_NO_TARGETS
  p.s.geonormal = p.s.normal;  // most layouts do not store it
#endif
  PathVertex v = pathVertex(p.s, p.toEye);
  PathLight albedos = albedosOf(v);
  if (kFiltered == 0u) albedos.scattered = vec3(1.0);
  if (lit) {
    pathSeed = rayHash(floatBitsToUint(p.s.position)).x;
    for (uint i = push.first; i < push.end; ++i) {
      pathIndex = i;
      pathPair = 0u;
      PathLight light = pathLight(frame, v, distance(p.s.position, view.eye));
      light.scattered /= albedos.scattered;
      light.mirrored /= albedos.mirrored;
      scattered += vec4(light.scattered, luminance(light.scattered) * luminance(light.scattered));
      mirrored += vec4(light.mirrored, luminance(light.mirrored) * luminance(light.mirrored));
    }
  }
  if (push.end < push.samples) {
    imageStore(pathSum, place, scattered);
    if (kFiltered != 0u) imageStore(mirroredSum, place, mirrored);
    return;
  }
  if (kFiltered != 0u) {
    writeForFilter(frame, place, p, v, scattered, mirrored, lit);
    return;
  }
  if (p.shadedSeparately) return;
  vec3 mean = scattered.rgb / float(push.samples);
  vec4 light = vec4(0.0);
  if (kPathsFromLights != 0u)
    light = p.lit ? vec4(min(p.emitted + mean * frame.exposure, vec3(65504.0)), 1.0) : vec4(0.0);
  else
    light = imageLoad(lightTarget, place) + vec4(lit ? (mean - p.radiance) * frame.exposure : vec3(0.0), 0.0);
  imageStore(lightTarget, place, max(light, vec4(0.0)));
}
