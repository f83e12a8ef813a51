#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// Path tracing from the visible surface of each pixel (Kajiya 1986, The Rendering Equation). At each surface, one light
// and one direction of the environment are sampled, and the path goes on in a direction of the surface's lobes. The
// environment is sampled in both ways, weighted by the balance heuristic (Veach and Guibas 1995, Optimally Combining
// Sampling Techniques for Monte Carlo Rendering). From the fourth surface on, paths end at random in proportion to what
// they still carry (Russian roulette).
//
// Inputs: the G-buffer, the scene's BVHs (FrameConstants::rayScene), the environment's image and cells. `pathSum`
// accumulates the radiance over several passes. The last pass writes the lit picture: with kPathsFromLights, all light;
// otherwise it adds to the picture of another technique, and replaces that technique's light of the environment, which
// nothing blocks.
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

layout(set = 0, binding = AFTER_LIT_MAPS) uniform sampler2D environmentPicture;
layout(set = 0, binding = AFTER_LIT_MAPS + 1, rgba32f) uniform image2DArray pathSum;

// Environment light and light between surfaces include multiple reflections between facets, as prefiltered environments
// do.
uint pathShading() { return kShading == kShadingBlinnPhong ? kShadingBlinnPhong : kShadingGgxCompensated; }

uint pathSeed;   // of the pixel
uint pathIndex;  // number of the sample
uint pathPair;   // the next pair of dimensions
vec2 nextSample() { return sobolSample(pathIndex, pathPair++, pathSeed); }

// --- lobes -----------------------------------------------------------------------------------------------------------

struct PathVertex {
  Surface s;
  vec3 toEye;
  SurfaceBrdf brdf;
  float alpha;
  float specular;  // probability with which the specular lobe is sampled
};

PathVertex pathVertex(Surface s, vec3 toEye) {
  PathVertex v;
  s.scattered = surfaceReflectance(s, splitSum(s, toEye)).scattered;
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

// --- direct light ----------------------------------------------------------------------------------------------------

vec3 rayOrigin(Surface s, float distance) { return s.position + s.geonormal * rayOffset(s.position, distance); }

// Chooses one light by what it would add without shadows, from up to kCandidates lights (Talbot, Cline and Egbert 2005,
// Importance Resampling for Global Illumination), and returns the light that the surface reflects of it.
vec3 lightOfLights(FrameConstants frame, PathVertex v, SurfaceBrdf brdf, uint shading, float distance) {
  const uint kCandidates = 32u;
  uint count = frame.lightCount, candidates = min(count, kCandidates);
  if (kLights == 0u || count == 0u) return vec3(0.0);
  vec2 u = nextSample();
  uint start = min(uint(u.x * float(count)), count - 1u);
  float stride = float(count) / float(candidates), total = 0.0, pick = u.y;
  vec3 chosen = vec3(0.0), toLight = vec3(0.0);
  float weight = 1.0, far = 0.0;
  for (uint i = 0u; i < candidates; ++i) {
    Light light = frameLight(frame, (start + uint(float(i) * stride)) % count);
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
    far = lightIsDirectional(light.type) ? 3.0e38 : length(light.position - v.s.position);
  }
  if (total == 0.0) return vec3(0.0);
  Ray ray = Ray(rayOrigin(v.s, distance), vec3(0.0), toLight, 0.0, far * (1.0 - 1e-5));
  return isBlocked(frame, ray) ? vec3(0.0) : chosen * (total / weight * stride);
}

vec3 lightOfSky(FrameConstants frame, RayScene scene, PathVertex v, float distance) {
  if (!hasCells(scene, frame)) return vec3(0.0);
  vec3 toLight = sampleSky(frame, scene);
  vec3 sent = pathReflectance(v, toLight);
  if (maxChannel(sent) <= 0.0) return vec3(0.0);
  float density = skyDensity(frame, scene, toLight);
  sent *= skyRadiance(frame, toLight) / (density + pathDensity(v, toLight));
  return isBlocked(frame, Ray(rayOrigin(v.s, distance), vec3(0.0), toLight, 0.0, 3.0e38)) ? vec3(0.0) : sent;
}

// --- path ------------------------------------------------------------------------------------------------------------

Surface hitSurface(FrameConstants frame, Ray ray, RayHit hit) {
  SurfacePoint p = rayPoint(frame, ray, hit);
  Surface s = evaluateMaterial(frame, frameMaterial(frame, frameInstance(frame, hit.instance).material), p);
  // Both normals on the side that the ray comes from.
  if (dot(s.normal, ray.direction) >= 0.0) s.normal = s.geonormal;
  if ((s.flags & kSurfaceUnlit) != 0u) s.emissive = s.baseColor;
  return (s.flags & kSurfaceUnlit) != 0u ? withoutReflection(s) : s;
}

vec3 pathRadiance(FrameConstants frame, Surface visible, vec3 toEye, float fromEye) {
  RayScene scene = RaySceneRef(frame.rayScene).v;
  PathVertex v = pathVertex(visible, toEye);
  vec3 radiance = lightOfSky(frame, scene, v, fromEye), carried = vec3(1.0);
  if (kPathsFromLights != 0u)
    radiance += lightOfLights(frame, v, surfaceBrdf(v.s, toEye, kShading), kShading, fromEye);
  float distance = fromEye;
  bool goesOn = true;
  for (uint bounce = 0u; goesOn && bounce <= push.bounces; ++bounce) {
    vec3 toLight = sampleLobes(v);
    float density = pathDensity(v, toLight);
    carried *= pathReflectance(v, toLight) / max(density, 1e-30);
    float left = maxChannel(carried), survives = bounce < 3u ? 1.0 : min(left, 0.95);
    goesOn = left > 0.0 && density > 0.0 && nextSample().x < survives;
    if (!goesOn) continue;
    carried /= survives;
    Ray ray = Ray(rayOrigin(v.s, distance), vec3(0.0), toLight, 0.0, 3.0e38);
    RayHit hit = traceRay(frame, ray, kRayTwoSided);
    goesOn = isHit(hit) && bounce < push.bounces;
    if (!isHit(hit) && hasCells(scene, frame))
      radiance += carried * skyRadiance(frame, toLight) * (density / (density + skyDensity(frame, scene, toLight)));
    if (!goesOn) continue;
    distance = hit.distance;
    v = pathVertex(hitSurface(frame, ray, hit), -toLight);
    vec3 sent = v.s.emissive + lightOfLights(frame, v, v.brdf, pathShading(), distance);
    radiance += carried * (sent + lightOfSky(frame, scene, v, distance));
  }
  return radiance;
}

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) { return vec3(0.0); }

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
  vec3 sum = push.first > 0u ? imageLoad(pathSum, place).rgb : vec3(0.0);
  if (lit) {
#ifndef GBUFFER_NO_TARGETS
    p.s.geonormal = p.s.normal;  // most layouts do not store it
#endif
    pathSeed = rayHash(floatBitsToUint(p.s.position)).x;
    for (uint i = push.first; i < push.end; ++i) {
      pathIndex = i;
      pathPair = 0u;
      sum += pathRadiance(frame, p.s, p.toEye, distance(p.s.position, view.eye));
    }
  }
  if (push.end < push.samples) {
    imageStore(pathSum, place, vec4(sum, 0.0));
    return;
  }
  if (p.shadedSeparately) return;
  vec3 mean = sum / float(push.samples);
  vec4 light = vec4(0.0);
  if (kPathsFromLights != 0u)
    light = p.lit ? vec4(min(p.emitted + mean * frame.exposure, vec3(65504.0)), 1.0) : vec4(0.0);
  else
    light = imageLoad(lightTarget, place) + vec4(lit ? (mean - p.radiance) * frame.exposure : vec3(0.0), 0.0);
  imageStore(lightTarget, place, max(light, vec4(0.0)));
}
