// The light that a path's surface receives directly: one of the lights, one direction of the environment, and one point
// of the emissive surfaces. Each function returns a ray, and the light that it brings if nothing blocks it. Light that
// paths hit is weighted by the densities of the last two (balance heuristic, Veach and Guibas 1995, Optimally Combining
// Sampling Techniques for Monte Carlo Rendering).
#ifndef LATELIGHT_PATH_LIGHTS_GLSL
#define LATELIGHT_PATH_LIGHTS_GLSL
#include "render/glsl/lights.glsl"
#include "render/lighting/reference/path_lobes.glsl"

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

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CellsRef { EnvironmentCell v[]; };

bool hasCells(RayScene scene, FrameConstants frame) { return hasEnvironment(frame) && scene.environment != 0ul; }

vec3 skyRadiance(FrameConstants frame, vec3 direction) {
  vec2 uv = equirectangular(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
  return textureLod(environmentPicture, uv, 0.0).rgb * frame.environmentIntensity;
}

float skyDensity(FrameConstants frame, RayScene scene, vec3 direction) {
  vec2 uv = equirectangular(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
  uvec2 cells = uvec2(kEnvironmentColumns, kEnvironmentRows);
  uvec2 cell = min(uvec2(vec2(fract(uv.x), uv.y) * vec2(cells)), cells - 1u);
  return CellsRef(scene.environment).v[cell.y * kEnvironmentColumns + cell.x].density;
}

vec3 sampleSky(FrameConstants frame, RayScene scene) {
  vec2 u = nextSample(), inside = nextSample();
  uint count = kEnvironmentColumns * kEnvironmentRows;
  uint index = min(uint(u.x * float(count)), count - 1u);
  EnvironmentCell cell = CellsRef(scene.environment).v[index];
  if (u.y >= cell.threshold) index = cell.alias;
  float row = float(index / kEnvironmentColumns), rows = float(kEnvironmentRows);
  float z = mix(cos(kPi * row / rows), cos(kPi * (row + 1.0) / rows), inside.y);
  float across = (float(index % kEnvironmentColumns) + inside.x) / float(kEnvironmentColumns);
  float turn = (across - 0.5) * 2.0 * kPi, radius = sqrt(max(1.0 - z * z, 0.0));
  vec3 own = vec3(radius * cos(turn), -radius * sin(turn), z);
  return rotateToEnvironment(own, frame.environmentCos, -frame.environmentSin);
}

LightRay rayToSky(FrameConstants frame, RayScene scene, PathVertex v) {
  if (!hasCells(scene, frame)) return noLightRay();
  vec3 toLight = sampleSky(frame, scene);
  float density = skyDensity(frame, scene, toLight) + pathDensity(v, toLight);
  return LightRay(pathReflectance(v, toLight) * skyRadiance(frame, toLight) / density, toLight, 3.0e38);
}

// --- lights ----------------------------------------------------------------------------------------------------------

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightSizesRef { float v[]; };

// Chooses one light by what it would add without shadows, from up to kCandidates lights (Talbot, Cline and Egbert 2005,
// Importance Resampling for Global Illumination), and a point of its disk, as --shadows rays does.
LightRay rayToLight(FrameConstants frame, PathVertex v, SurfaceBrdf brdf, uint shading, vec3 origin) {
  const uint kCandidates = 32u;
  uint count = frame.lightCount, candidates = min(count, kCandidates);
  if (kLights == 0u || count == 0u) return noLightRay();
  vec2 u = nextSample();
  uint start = min(uint(u.x * float(count)), count - 1u);
  float stride = float(count) / float(candidates), total = 0.0, pick = u.y;
  vec3 chosen = vec3(0.0), toLight = vec3(0.0);
  float weight = 1.0;
  uint index = 0u;
  for (uint i = 0u; i < candidates; ++i) {
    uint candidate = (start + uint(float(i) * stride)) % count;
    Light light = frameLight(frame, candidate);
    LightSample arriving = sampleLight(light, v.s.position);
    vec3 sent = dot(v.s.geonormal, arriving.toLight) > 0.0 ? shadeLight(brdf, arriving, shading) : vec3(0.0);
    float share = maxChannel(sent);
    total += share;
    bool taken = share > 0.0 && pick * total < share;
    float kept = share / max(total, 1e-30);
    pick = clamp(taken ? pick / kept : (pick - kept) / max(1.0 - kept, 1e-6), 0.0, 0.999999);
    if (!taken) continue;
    chosen = sent;
    weight = share;
    toLight = arriving.toLight;
    index = candidate;
  }
  if (total == 0.0) return noLightRay();
  Light light = frameLight(frame, index);
  float size = LightSizesRef(push.lightSizes).v[index];
  mat3 axes = rayAxes(toLight);
  vec2 disk = diskSample(nextSample()) * size;
  vec3 moved = axes[0] * disk.x + axes[1] * disk.y;
  bool directional = lightIsDirectional(light.type);
  vec3 way = directional ? toLight + moved : light.position + moved - origin;
  float away = length(way);
  // Geometry nearer to a light than its radius is the light's own body.
  float far = directional ? 3.0e38 : max(away - size - rayOffset(light.position, away), 0.0);
  return LightRay(chosen * (total / weight * stride), way / away, far);
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
