// The light that a path's surface receives directly: one of the lights, one direction of the environment, and one point
// of the emissive surfaces. Each function returns a ray, and the light that it brings if nothing blocks it. Light that
// paths hit is weighted by the densities of the last two (balance heuristic, Veach and Guibas 1995, Optimally Combining
// Sampling Techniques for Monte Carlo Rendering).
#ifndef LATELIGHT_PATH_LIGHTS_GLSL
#define LATELIGHT_PATH_LIGHTS_GLSL
#define SKY_PICTURE environmentPicture
#include "render/glsl/light_choice.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/sky_samples.glsl"
#include "render/glsl/area_lights.glsl"
#include "render/lighting/reference/path_lobes.glsl"
#include "shared/area_samples.h"

struct LightRay {
  vec3 radiance;  // toward the eye, if nothing blocks the ray
  vec3 toLight;
  float far;      // meters
};
LightRay noLightRay() { return LightRay(vec3(0.0), vec3(0.0, 0.0, 1.0), 0.0); }

vec3 rayOrigin(Surface s, float distance) { return s.position + s.geonormal * rayOffset(s.position, distance); }

// The surface that a ray hits.
struct PathHit {
  Surface s;
  vec3 plane;  // unit normal of the triangle
  float area;  // of the triangle, m^2
};

PathHit surfaceAt(FrameConstants frame, Ray ray, RayHit hit) {
  SurfacePoint p = rayPoint(frame, ray, hit);
  Material m = frameMaterial(frame, frameInstance(frame, hit.instance).material);
  PathHit at;
  at.s = evaluateMaterial(frame, m, p);
  // Both normals on the side that the ray comes from.
  if (dot(at.s.normal, ray.direction) >= 0.0) at.s.normal = at.s.geonormal;
  bool unlit = (at.s.flags & kSurfaceUnlit) != 0u;
  if (unlit) at.s.emissive = at.s.baseColor;
  if (unlit) at.s = withoutReflection(at.s);
  if ((m.flags & kMaterialMasked) != 0u && masked(m, p)) at.s.emissive = vec3(0.0);
  at.area = 0.5 * length(p.plane);
  at.plane = p.plane / max(2.0 * at.area, 1e-30);
  return at;
}

// --- environment -----------------------------------------------------------------------------------------------------

LightRay rayToSky(FrameConstants frame, RayScene scene, PathVertex v) {
  if (!hasCells(scene, frame)) return noLightRay();
  vec2 u = nextSample(), inside = nextSample();
  vec3 toLight = sampleSky(frame, scene, u, inside);
  float density = skyDensity(frame, scene, toLight) + pathDensity(v, toLight);
  return LightRay(pathReflectance(v, toLight) * skyRadiance(frame, toLight) / density, toLight, 3.0e38);
}

// --- lights ----------------------------------------------------------------------------------------------------------

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightSizesRef { float v[]; };

// Chooses one light, and a point of its disk, as --shadows rays does.
LightRay rayToLight(FrameConstants frame, PathVertex v, SurfaceBrdf brdf, uint shading, vec3 origin) {
  LightChoice choice = chooseLight(frame, v.s, brdf, shading, nextSample());
  if (choice.light == vec3(0.0)) return noLightRay();
  Light light = frameLight(frame, choice.index);
  float size = LightSizesRef(push.lightSizes).v[choice.index];
  mat3 axes = rayAxes(choice.toLight);
  vec2 disk = diskSample(nextSample()) * size;
  vec3 moved = axes[0] * disk.x + axes[1] * disk.y;
  bool directional = lightIsDirectional(light.type);
  vec3 way = directional ? choice.toLight + moved : light.position + moved - origin;
  float away = length(way);
  // Geometry nearer to a light than its radius is the light's own body.
  float far = directional ? 3.0e38 : max(away - size - rayOffset(light.position, away), 0.0);
  return LightRay(choice.light, way / away, far);
}

// --- area lights -----------------------------------------------------------------------------------------------------

// Area lights are no surfaces: rays pass through them, and cameras do not see them. They light surfaces as the lighting
// techniques' lights do, so the first surface of a path reflects them by --shading.

bool hasAreaLights(FrameConstants frame) { return kSampledAreaLights != 0u && frame.areaLightCount > 0u; }

vec3 areaReflectance(PathVertex v, vec3 toLight, uint bounce) {
  if (bounce > 0u || kShading == pathShading()) return pathReflectance(v, toLight);
  if (dot(v.s.geonormal, toLight) <= 0.0) return vec3(0.0);
  return shadeLight(surfaceBrdf(v.s, v.toEye, kShading), LightSample(toLight, vec3(1.0), 1.0), kShading);
}

// Meters to a point of an area light, less what a surface at the same place may be off.
float areaDistance(AreaLight light, AreaSample point) {
  return max(point.distance - rayOffset(light.center, point.distance), 0.0);
}

// Chooses one area light, and a point on it.
LightRay rayToArea(FrameConstants frame, PathVertex v, SurfaceBrdf brdf, uint shading, vec3 origin) {
  float choice = nextSample().x, count = float(frame.areaLightCount);
  vec2 u = nextSample();
  AreaLight light = frameAreaLight(frame, min(uint(choice * count), frame.areaLightCount - 1u));
  AreaSample point = sampleArea(light, origin, u);
  if (point.density <= 0.0 || dot(v.s.geonormal, point.toLight) <= 0.0) return noLightRay();
  vec3 reflected = shadeLight(brdf, LightSample(point.toLight, vec3(1.0), 1.0), shading);
  vec3 sent = reflected * light.radiance / (point.density / count + pathDensity(v, point.toLight));
  return LightRay(sent, point.toLight, areaDistance(light, point));
}

// Returns the radiance of all area lights that a ray hits before `far`, weighted against rayToArea(). `density`: of the
// ray's direction, 1/sr.
vec3 areaRadiance(FrameConstants frame, Ray ray, float far, float density) {
  vec3 radiance = vec3(0.0);
  for (uint i = 0u; i < frame.areaLightCount; ++i) {
    AreaLight light = frameAreaLight(frame, i);
    AreaSample point = hitArea(light, ray.origin, ray.direction);
    if (point.density <= 0.0 || areaDistance(light, point) >= far) continue;
    radiance += light.radiance * (density / (density + point.density / float(frame.areaLightCount)));
  }
  return radiance;
}

// --- emissive surfaces -----------------------------------------------------------------------------------------------

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer EmittersRef { RayEmitter v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EmitterSumsRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EmitterIndicesRef { uint v[]; };

// Probability with which rayToEmitter() chooses an emissive triangle.
float emitterShare(RayScene scene, uint index) {
  EmitterSumsRef sums = EmitterSumsRef(push.emitterSums);
  float before = index == 0u ? 0.0 : sums.v[index - 1u];
  return max(sums.v[index] - before, 0.0) / max(sums.v[scene.emitterCount - 1u], 1e-30);
}

// Density in solid angle, 1/sr, of a point that is uniform on a triangle of this area.
float solidAngleDensity(float area, float distance, float cosine) {
  return distance * distance / max(area * abs(cosine), 1e-30);
}

// 1/sr: density of rayToEmitter() in the direction of what a ray hits.
float emitterDensity(RayScene scene, RayHit hit, PathHit at, vec3 toLight) {
  if (kEmitters == 0u) return 0.0;
  uint first = EmitterIndicesRef(scene.emitterIndices).v[hit.instance];
  if (first == kRayNone) return 0.0;
  return emitterShare(scene, first + hit.triangle) *
         solidAngleDensity(at.area, hit.distance, dot(at.plane, toLight));
}

// Returns the first emitter whose running sum exceeds the fraction u of the total.
uint chooseEmitter(RayScene scene, float u) {
  EmitterSumsRef sums = EmitterSumsRef(push.emitterSums);
  uint low = 0u, high = scene.emitterCount - 1u;
  float target = u * sums.v[high];
  while (low < high) {
    uint middle = (low + high) / 2u;
    if (sums.v[middle] > target) high = middle;
    else low = middle + 1u;
  }
  return low;
}

// Chooses an emissive triangle by its power, and a point on it.
LightRay rayToEmitter(FrameConstants frame, RayScene scene, PathVertex v, vec3 origin) {
  if (kEmitters == 0u) return noLightRay();
  float choice = nextSample().x;
  vec2 u = nextSample();
  uint index = chooseEmitter(scene, choice);
  RayEmitter emitter = EmittersRef(scene.emitters).v[index];
  float side = sqrt(u.x);
  RayHit hit = noHit();
  hit.instance = emitter.instance;
  hit.corners = uvec3(emitter.corners[0], emitter.corners[1], emitter.corners[2]);
  hit.weights = vec3(1.0 - side, side * (1.0 - u.y), side * u.y);
  hit.front = true;
  PathHit at = surfaceAt(frame, Ray(origin, vec3(0.0), vec3(0.0), 0.0, 0.0), hit);
  vec3 way = at.s.position - origin;
  float far = length(way);
  vec3 toLight = way / max(far, 1e-30);
  float density = emitterShare(scene, index) * solidAngleDensity(at.area, far, dot(at.plane, toLight));
  if (density <= 0.0 || far <= 0.0) return noLightRay();
  vec3 sent = pathReflectance(v, toLight) * at.s.emissive / (density + pathDensity(v, toLight));
  return LightRay(sent, toLight, far - rayOffset(at.s.position, far));
}

#endif
