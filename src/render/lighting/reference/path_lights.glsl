// The light that a path's surface receives directly: one of the lights, one direction of the environment, and one point
// of the emissive surfaces and of the area lights. Each function returns a ray, and the light that it brings if nothing
// blocks it. Light that paths hit is weighted by the densities of the last three (balance heuristic, Veach and Guibas
// 1995, Optimally Combining Sampling Techniques for Monte Carlo Rendering).
#ifndef LATELIGHT_PATH_LIGHTS_GLSL
#define LATELIGHT_PATH_LIGHTS_GLSL
#define SKY_PICTURE environmentPicture
#include "render/glsl/lights.glsl"
#include "render/glsl/sky_samples.glsl"
#include "render/glsl/area_lights.glsl"
#include "render/lighting/reference/path_hits.glsl"
#include "render/lighting/reference/path_light_choice.glsl"
#include "shared/area_samples.h"

struct LightRay {
  vec3 radiance;  // that arrives if nothing blocks the ray; of lights, what is reflected of it
  vec3 toLight;
  float far;      // meters
  float density;  // of the direction, 1/sr; not for lights
  // For punctual lights: the direction to the center, which shading uses, and the intensity times attenuation.
  vec3 centered, arriving;
  bool close;  // the light is within a few of its radii
};
LightRay lightRay(vec3 radiance, vec3 toLight, float far, float density) {
  return LightRay(radiance, toLight, far, density, toLight, vec3(0.0), false);
}
LightRay noLightRay() { return lightRay(vec3(0.0), vec3(0.0, 0.0, 1.0), 0.0, 0.0); }

// The origin of a ray from a surface, on the side of the direction.
vec3 rayOrigin(Surface s, vec3 direction, float distance) {
  float side = kLayers != 0u && dot(s.geonormal, direction) < 0.0 ? -1.0 : 1.0;
  return s.position + s.geonormal * (side * rayOffset(s.position, distance));
}

// --- environment -----------------------------------------------------------------------------------------------------

// These require hasCells(). `skies`: directions that are sampled at the surface, whose density is that of all together.

// `bits`: a point of the unit square, times 2^32.
LightRay rayToSky(FrameConstants frame, RayScene scene, uvec2 bits, float skies) {
  SkySample sky = sampleSky(frame, scene, bits);
  return lightRay(skyRadiance(frame, sky.direction), sky.direction, 3.0e38, sky.density * skies);
}

// Returns the ray in a direction of the surface's lobes.
LightRay rayOnward(FrameConstants frame, RayScene scene, PathVertex v, float skies) {
  vec3 toLight = nextDirection(v);
  return lightRay(skyRadiance(frame, toLight), toLight, 3.0e38, skyDensity(frame, scene, toLight) * skies);
}

// --- lights ----------------------------------------------------------------------------------------------------------

// Chooses one light, and a point of its disk, as --shadows rays does.
LightRay rayToLight(FrameConstants frame, PathVertex v, float distance) {
  LightChoice choice = chooseLight(frame, v, nextSample());
  if (choice.light == vec3(0.0)) return noLightRay();
  Light light = frameLight(frame, choice.index);
  mat3 axes = rayAxes(choice.toLight);
  vec2 disk = diskSample(nextSample()) * light.size;
  vec3 moved = axes[0] * disk.x + axes[1] * disk.y;
  bool directional = lightIsDirectional(light.type);
  vec3 origin = rayOrigin(v.s, choice.toLight, distance);
  vec3 way = directional ? choice.toLight + moved : light.position + moved - origin;
  float away = length(way);
  // Geometry nearer to a light than its radius is the light's own body.
  float far = directional ? 3.0e38 : max(away - light.size - rayOffset(light.position, away), 0.0);
  bool close = !directional && away < kCloseRadii * light.size;
  return LightRay(choice.light, way / away, far, 0.0, choice.toLight, choice.arriving, close);
}

// --- area lights -----------------------------------------------------------------------------------------------------

// Area lights are no surfaces: rays pass through them, and cameras do not see them. They light surfaces as the lighting
// techniques' lights do, so the first surface of a path reflects them by --shading.

bool hasAreaLights(FrameConstants frame) { return kSampledAreaLights != 0u && frame.areaLightCount > 0u; }

// Meters to a point of an area light, less what a surface at the same place may be off.
float areaDistance(AreaLight light, AreaSample point) {
  return max(point.distance - rayOffset(light.center, point.distance), 0.0);
}

// Chooses one area light, and a point on it.
LightRay rayToArea(FrameConstants frame, PathVertex v) {
  float choice = nextSample().x, count = float(frame.areaLightCount);
  vec2 u = nextSample();
  AreaLight light = frameAreaLight(frame, min(uint(choice * count), frame.areaLightCount - 1u));
  AreaSample point = sampleArea(light, v.s.position, u);
  if (point.density <= 0.0) return noLightRay();
  return lightRay(light.radiance, point.toLight, areaDistance(light, point), point.density / count);
}

// Returns the radiance of all area lights that a ray hits between its `near` and `far`, weighted against rayToArea().
// `density`: of the ray's direction, 1/sr; `absorption`: of the volume that the ray is in, 1/m.
vec3 areaRadiance(FrameConstants frame, Ray ray, float far, float density, vec3 absorption) {
  vec3 radiance = vec3(0.0);
  for (uint i = 0u; i < frame.areaLightCount; ++i) {
    AreaLight light = frameAreaLight(frame, i);
    AreaSample point = hitArea(light, ray.origin, ray.direction);
    float away = areaDistance(light, point);
    if (point.density <= 0.0 || away < ray.near || away >= far) continue;
    radiance += light.radiance * absorbed(absorption, away - ray.near) *
                (density / (density + point.density / float(frame.areaLightCount)));
  }
  return radiance;
}

// --- emissive surfaces -----------------------------------------------------------------------------------------------

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer EmitterSumsRef { float v[]; };

// Probability with which rayToEmitter() chooses an emissive triangle.
float emitterShare(RayScene scene, uint index) {
  EmitterSumsRef sums = EmitterSumsRef(emitterSums);
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
  uint first = sceneWordAt(scene.emitterIndices, hit.instance);
  if (first == kRayNone) return 0.0;
  return emitterShare(scene, first + hit.triangle) *
         solidAngleDensity(at.area, hit.distance, dot(at.plane, toLight));
}

// Returns the first emitter whose running sum exceeds the fraction u of the total.
uint emitterByPower(RayScene scene, float u) {
  EmitterSumsRef sums = EmitterSumsRef(emitterSums);
  uint low = 0u, high = scene.emitterCount - 1u;
  float target = u * sums.v[high];
  while (low < high) {
    uint middle = (low + high) / 2u;
    if (sums.v[middle] > target) high = middle;
    else low = middle + 1u;
  }
  return low;
}

// The light that a surface receives of a triangle, relative to the triangle's power: from its center, and not less than
// a twentieth of that at the best angles, because the center is not the whole triangle. The back sides of triangles
// emit, too, but those of closed meshes emit inward.
float emitterGeometry(FrameConstants frame, RayEmitter emitter, PathVertex v) {
  Instance instance = frameInstance(frame, emitter.instance);
  uint64_t positions = frameMesh(frame, instance.mesh).positions;
  mat3 toWorld = mat3(instance.objectToWorld);
  vec3 a = toWorld * positionAt(positions, emitter.corners[0]), b = toWorld * positionAt(positions, emitter.corners[1]);
  vec3 c = toWorld * positionAt(positions, emitter.corners[2]), plane = cross(b - a, c - a);
  vec3 to = (a + b + c) * (1.0 / 3.0) + ((instance.objectToWorld[3] - v.s.position) + instance.translationLow);
  float area = 0.5 * length(plane), distance2 = dot(to, to) + area, inverse = inversesqrt(max(distance2, 1e-30));
  float receives = dot(v.s.normal, to) * inverse, sends = -dot(plane, to) * inverse / max(2.0 * area, 1e-30);
  if ((instance.flags & kInstanceClockwise) != 0u) sends = -sends;
  if (v.coated) receives = abs(receives);
  return max(receives, 0.05) * max(sends, 0.05) * inverse * inverse;
}

struct EmitterChoice {
  uint index;
  float weight;  // the chosen triangle's power stands for this multiple of it
};

// Chooses one of a few triangles, which are chosen by power, in proportion to emitterGeometry() (Talbot, Cline and
// Egbert 2005). `u` is in [0, 1)^2.
EmitterChoice chooseEmitter(FrameConstants frame, RayScene scene, PathVertex v, vec2 u) {
  const uint kCandidates = 4u;
  EmitterChoice choice = EmitterChoice(0u, 0.0);
  uint count = min(kCandidates, scene.emitterCount);
  float total = 0.0, chosen = 1.0, pick = u.y;
  uint i = 0u;
  do {
    uint index = emitterByPower(scene, (float(i) + u.x) / float(count));
    float share = emitterGeometry(frame, sceneEmitter(scene, index), v);
    if (takesCandidate(pick, total, share)) choice.index = index, chosen = share;
  } while (++i < count);
  choice.weight = total / (chosen * float(count));
  return choice;
}

// A point of an emissive surface.
struct EmitterPoint {
  vec3 position;
  vec3 plane;  // normal of the triangle; its length is twice the area
  uint material;
  SurfacePoint at;
};

EmitterPoint emitterPoint(FrameConstants frame, RayEmitter emitter, vec3 origin, vec2 u) {
  float side = sqrt(u.x);
  RayHit hit = noHit();
  hit.instance = emitter.instance;
  hit.corners = uvec3(emitter.corners[0], emitter.corners[1], emitter.corners[2]);
  hit.weights = vec3(1.0 - side, side * (1.0 - u.y), side * u.y);
  hit.front = true;
  SurfacePoint at = rayPoint(frame, Ray(origin, vec3(0.0), vec3(0.0), 0.0, 0.0), hit);
  return EmitterPoint(at.position, at.plane, frameInstance(frame, emitter.instance).material, at);
}

// The textures that emission depends on, by the coat above it, too.
const uint kEmissionSlots = 1u << kTextureBaseColor | 1u << kTextureEmissive | 1u << kTextureClearcoat |
                            1u << kTextureClearcoatRoughness | 1u << kTextureClearcoatNormal;

// The radiance that it emits in a direction.
vec3 emittedRadiance(FrameConstants frame, EmitterPoint p, vec3 direction) {
  Material m = frameMaterial(frame, p.material);
  fetchTexels(frame, p.material, p.at, kEmissionSlots);
  if ((m.flags & kMaterialMasked) != 0u && masked(m, p.at)) return vec3(0.0);
  if ((m.flags & kMaterialUnlit) != 0u) return baseColor(m, p.at).rgb;
  vec3 emitted = m.emissive;
  if (hasTexture(m, kTextureEmissive)) emitted *= sampleTexture(m, kTextureEmissive, p.at).rgb;
  SurfaceLayers l = emptyLayers();
  if ((kLayers & kLayerClearcoat) != 0u && (m.flags & kMaterialLayered) != 0u) findClearcoat(l, m, p.at);
  return emitted * belowClearcoat(l, direction);
}

// Chooses an emissive triangle, and a point on it. It is weighted as if it were chosen by power only, as
// emitterDensity() states.
LightRay rayToEmitter(FrameConstants frame, RayScene scene, PathVertex v, float distance) {
  if (kEmitters == 0u || scene.emitterCount == 0u) return noLightRay();
  EmitterChoice choice = chooseEmitter(frame, scene, v, nextSample());
  EmitterPoint p = emitterPoint(frame, sceneEmitter(scene, choice.index), v.s.position, nextSample());
  vec3 way = p.position - rayOrigin(v.s, p.position - v.s.position, distance);
  float far = length(way), area2 = length(p.plane);
  vec3 toLight = way / max(far, 1e-30);
  float facing = dot(p.plane, toLight) / max(area2, 1e-30);
  float density = emitterShare(scene, choice.index) * solidAngleDensity(0.5 * area2, far, facing);
  if (density <= 0.0 || far <= 0.0) return noLightRay();
  return lightRay(emittedRadiance(frame, p, toLight) * choice.weight, toLight, far - rayOffset(p.position, far), density);
}

#endif
