#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_arithmetic : require
// variants: layout, visible
// functions: kept
// Path tracing from the visible surface of each pixel (Kajiya 1986, The Rendering Equation). At each surface, one
// light, directions of the environment, one point of the emissive surfaces and one of the area lights are sampled, and
// the path goes on in a direction of the surface's lobes, which also finds the last three. From the fourth surface
// on, paths end at random (Russian roulette): those that carry a quarter of their light go on with a chance of a half,
// because sampling their later surfaces less often than this costs more by noise than it saves.
//
// Inputs: the G-buffer, the scene's BVHs and emitters (FrameConstants::rayScene), an environment's image and its cells.
// Worlds may have several environments, each of which has passes of its own, which skip the views of the others.
// `pathSum` accumulates the radiance over several passes. The last pass writes the lit picture: with kPathsFromLights,
// all light; otherwise it adds to the picture of another technique, and replaces that technique's light of the
// environment, which nothing blocks. The technique adds no light of area lights then.
//
// The G-buffer has neither coats nor translucent surfaces. With kPathsFromEye, a ray from the eye finds them, and the
// paths of such pixels start at the eye. They contain all light, also that of the lights. Their coverage, of which the
// rest is background, is in pathSum.a.
//
// With kFiltered, `pathSum` holds light through the Lambertian lobe and `mirroredSum` light through the specular lobe.
// Both are divided by the albedos of these lobes, and w sums the squares of the samples' luminances. The last pass
// writes the inputs of indirect_filter.glsl. Paths from the eye are entirely in `mirroredSum`, and their coverage is in
// the lit picture.
//
// With kSharedPaths, the shader only writes a record per path, and path_sharing.comp computes the sums from these.
#define ONE_SAMPLE
#define LOADS_TEXELS
#include "render/glsl/common.glsl"

layout(constant_id = kLimitsWorkConstant) const uint kLimitsWork = 0;  // 1: paths end before lavapipe ends their loops
#define RAY_COUNTS_WORK (kLimitsWork != 0u)
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/ray_point.glsl"  // after gbuffer_read.glsl, which may define sampleTexture()
#include "render/glsl/surface.glsl"
#include "render/lighting/reference/paths_push.h"

layout(push_constant, scalar) uniform Push { PathsPush push; };
layout(constant_id = kFilteredConstant) const uint kFiltered = 0;
layout(constant_id = kEmittersConstant) const uint kEmitters = 0;  // 1: the scene has emissive surfaces
layout(constant_id = kSampledAreaLightsConstant) const uint kSampledAreaLights = 0;  // 1: the scene has area lights
layout(constant_id = kSharedPathsConstant) const uint kSharedPaths = 0;  // 1: writes records, which path_sharing.comp reads

layout(set = 0, binding = AFTER_LIT_MAPS) uniform sampler2D environmentPicture;
uint64_t emitterSums;  // PathsPush, those of the view

#include "render/lighting/reference/path_lights.glsl"
#include "render/lighting/reference/path_record.glsl"
#include "render/lighting/reference/path_sums.glsl"

// A path under construction.
struct Path {
  PathLight sum;
  vec3 carried;     // fraction of the light at the ray's end that reaches the eye
  vec3 fromArea;    // the same for light of area lights
  vec3 share;       // of the specular lobe of the visible surface
  vec3 absorption;  // of the volume that the ray is in, 1/m
  Ray ray;
  float density;    // of the ray's direction, 1/sr
  float skies;      // directions of the environment that are sampled at the ray's origin
  float distance;   // meters that the ray traveled to the surface
  uint channel;     // of color that the path follows after a dispersing surface; kAllChannels before
  bool fromEye;     // the path started at the eye
  bool covers;      // it does not only pass blended surfaces
  // With kSharedPaths: light that `record` describes is not in `sum`. From the second surface on, `carried` is relative
  // to the light that leaves it, and from the third one on, to the light that arrives there.
  PathRecord record;
  bool recorded;
  vec3 recordAlbedo;
  vec3 first;       // fraction of the light from the second surface that reaches the eye; 1 before
  vec3 lambertian;  // fraction of the light at the ray's end that is part of record.reflected
  vec3 onward;      // fraction of the light from the third surface that leaves the second one; 1 before
  bool deep;        // light at the ray's end is part of record.received
};
const uint kAllChannels = 3u;

// Path::density of the eye's ray, 1/sr: nothing else samples its direction. A GPU may return 0 for a quotient whose
// divisor exceeds 2^126 (Vulkan specification, "Precision of Individual Operations"), so it is far below that.
const float kOnlyDirection = 1e30;

// Adds light that the path carries. `mirrored`: the fraction that the visible surface's specular lobe reflects;
// `lambertian`: the fraction that the recorded surface's Lambertian lobe reflects.
void add(inout Path path, vec3 radiance, vec3 mirrored, vec3 lambertian) {
  if (kSharedPaths != 0u) {
    if (path.deep) path.record.received += radiance;
    radiance *= path.onward;
    path.record.reflected += radiance * lambertian;
    radiance *= path.first * (1.0 - lambertian);
    if (path.deep) return;
  }
  path.sum.scattered += radiance * (1.0 - mirrored);
  path.sum.mirrored += radiance * mirrored;
}

// The fraction of light from a direction that the Lambertian lobe of the recorded surface reflects.
vec3 recordedShare(Path path, PathVertex v, vec3 toLight, uint bounce) {
  if (kSharedPaths == 0u || !path.recorded) return vec3(0.0);
  return bounce == 1u ? 1.0 - mirroredShare(v, toLight) : path.lambertian;
}

// Adds the light of a light at the recorded surface, all of which is shared.
void recordLight(inout Path path, PathVertex v, LightRay light, vec3 passed) {
  path.record.reflected += light.radiance * passed * (1.0 - mirroredShare(v, light.centered));
  path.record.lit = light.arriving * passed;
  path.record.toLight = packSnorm2x16(octahedralFromDirection(light.centered));
  path.record.flags = light.close && v.s.metallic > 0.5 ? kRecordGlares : 0u;
}

// Returns true if paths end before their surface of this bounce. Area lights are found by one more ray.
bool endsAt(FrameConstants frame, uint bounce) { return bounce > push.bounces + (hasAreaLights(frame) ? 1u : 0u); }

// Returns how many rays to the environment a surface of a path has. Below a sky, direct light at the visible surface
// has most of the noise, and one more ray there costs less than one more path. A filter removes the noise of a single
// ray if it is chosen among several directions. (lavapipe of Mesa 22.3.6 crashes if one function returns both as a
// struct.)
uint skyRays(FrameConstants frame, RayScene scene, uint index) {
  if (!hasCells(scene, frame)) return 0u;
  return index == 0u && kFiltered == 0u ? 4u : 1u;
}
uint directionsPerRay(uint index) { return index == 0u && kFiltered != 0u ? 4u : 1u; }

// A ray that is chosen among candidates, in proportion to what each would add if nothing blocked it (Talbot, Cline and
// Egbert 2005, Importance Resampling for Global Illumination).
struct RayChoice {
  LightRay light;
  vec3 sent;    // what the surface sends toward the eye of its light
  float pick;   // random number in [0, 1)
  float total;  // weight of all candidates
};

// Adds the light that the `index`th surface of a path receives directly. `next`: the bounce of the path's next surface.
// Emissive surfaces are sampled if follow() adds their emission there. Directions of the environment are consecutive
// points of one pair of dimensions, so all samples of a pixel are well distributed together. If a path could only find
// the environment after this surface, the direction in which it would go on is one more candidate, and the path ends.
void addDirectLight(inout Path path, FrameConstants frame, RayScene scene, PathVertex v, vec3 beyond, uint bounce,
                    uint next, uint index) {
  uint sky = skyRays(frame, scene, index), directions = sky > 0u ? directionsPerRay(index) : 0u;
  bool last = sky > 0u && endsAt(frame, next);
  uint skyPair = pathPair++, pickPair = pathPair;
  if (directions > 1u || last) ++pathPair;
  path.skies = float(sky * directions);
  LightRay lit = noLightRay(), emitted = noLightRay(), area = noLightRay(), onward = noLightRay();
  if (bounce > 0u || path.fromEye || (kPathFlags & kPathsFromLights) != 0u) lit = rayToLight(frame, v, path.distance);
  if (next <= push.bounces) emitted = rayToEmitter(frame, scene, v, path.distance);
  if (hasAreaLights(frame)) area = rayToArea(frame, v);
  if (last) onward = rayOnward(frame, scene, v, path.skies);
  uint rays = sky + (kSampledAreaLights != 0u ? 3u : 2u);
  uint i = 0u;
  do {  // one copy of the traversal
    bool isSky = i < sky, isLight = i == sky, isArea = i == sky + 2u;
    LightRay single = isLight ? lit : (isArea ? area : emitted);
    RayChoice c = RayChoice(single, vec3(0.0), 0.0, 0.0);
    uint candidates = isSky ? directions + (last ? 1u : 0u) : 1u;
    if (candidates > 1u)
      c.pick = sobolSample(pathIndex * sky + i, pickPair, pathSeed).x;
    uint j = 0u;
    do {
      LightRay light = isSky ? onward : single;
      if (isSky && j < directions)
        light = rayToSky(frame, scene, sobolBits((pathIndex * sky + i) * directions + j, skyPair, pathSeed),
                         path.skies);
      vec3 sent = light.radiance;
      if (!isLight)
        sent *= pathReflectance(v, light.toLight, isArea) / (light.density + pathDensity(v, light.toLight));
      float weight = j < candidates ? maxChannel(sent) : 0.0;
      if (takesCandidate(c.pick, c.total, weight)) c.light = light, c.sent = sent;
    } while (lanesGoOn(++j < candidates));
    if (!(c.total > 0.0)) continue;
    Ray ray = Ray(rayOrigin(v.s, c.light.toLight, path.distance), vec3(0.0), c.light.toLight, 0.0, c.light.far);
    vec3 absorption = dot(v.s.geonormal, c.light.toLight) < 0.0 ? beyond : path.absorption;
    vec3 passed = lightPassed(frame, ray, absorption) * (c.total / maxChannel(c.sent));
    if (kSharedPaths != 0u && isLight && path.recorded && bounce == 1u) {
      recordLight(path, v, c.light, passed);
      continue;
    }
    add(path, path.carried * c.sent * passed,
        bounce == 0u && !path.fromEye ? lobeShare(v, c.light.toLight) : path.share,
        recordedShare(path, v, c.light.toLight, bounce));
  } while (++i < rays && !rayWorkIsDone());
}

// With dispersion, a path follows one channel from the first surface on that refracts it.
void disperse(inout Path path, inout PathHit at) {
  SurfaceLayers l = at.layers;
  if ((kLayers & kLayerDispersion) == 0u || l.dispersion <= 0.0 || l.thickness <= 0.0 || l.transmission <= 0.0) return;
  if (path.channel == kAllChannels) {
    path.channel = min(uint(nextSample().x * 3.0), 2u);
    vec3 channel = 3.0 * vec3(equal(uvec3(0u, 1u, 2u), uvec3(path.channel)));
    path.carried *= channel;
    path.fromArea *= channel;
  }
  at.layers.ior = dispersedIor(l.ior, l.dispersion, path.channel);
}

// Returns true if the path passes the surface straight on, by the surface's transmittance.
bool passes(inout Path path, PathHit at, PathVertex v) {
  if (at.alpha < 1.0 && nextSample().x >= at.alpha) return true;
  path.covers = true;
  vec3 straight = kLayers != 0u && v.coated ? v.coats.straight : vec3(0.0);
  if (maxChannel(straight) <= 0.0) return false;
  float chance = min(0.75 * maxChannel(straight), 0.75);
  bool passed = nextSample().x < chance;
  vec3 kept = passed ? straight / chance : vec3(1.0 / (1.0 - chance));
  path.carried *= kept;
  path.fromArea *= kept;
  return passed;
}

// Returns true if pixels may share the second surface of a path: nothing translucent lies before it, it has neither
// coats nor transmittance, and the shading normal is that of all pixels. `index`: of the surface along the path.
bool sharesSurface(Path path, PathHit at, uint index, uint crossed) {
  const uint kNotPlain = kMaterialLayered | kMaterialBlended | kMaterialTransmissive;
  return kSharedPaths != 0u && !path.fromEye && index == 1u && crossed == 0u && !at.flipped &&
         (at.flags & kNotPlain) == 0u;
}

// Records the second surface of a path.
void beginRecord(inout Path path, PathVertex v, vec3 plane) {
  path.record = recordOf(v, plane);
  path.recordAlbedo = recordAlbedo(recordSurface(path.record), v.toEye);
  path.recorded = true;
  path.first = path.carried;
  path.carried = vec3(1.0);
}

// Most layouts do not store the normal of the visible triangle, so a ray may leave the visible surface on the side of
// its shading normal, but toward the back of its triangle. It then hits the triangle's own plane from the front, where
// nothing shines on the surface. Returns true for all surfaces in that plane, which exchange no light.
bool isInOwnPlane(Path path, PathHit at, RayHit hit, uint index) {
#ifdef GBUFFER_NO_TARGETS
  return false;
#else
  float height = hit.distance * abs(dot(path.ray.direction, at.plane));
  return index == 1u && !path.fromEye && height <= 1.5 * rayOffset(path.ray.origin, path.distance);
#endif
}

// Follows the ray of a path to the surface `v` that it hits, the `index`th one, and adds what the ray sees. `beyond` is
// the absorption on the surface's other side. Returns false if the path ends: `onlySky` ends it at any surface.
bool follow(inout Path path, FrameConstants frame, RayScene scene, uint index, uint bounce, bool onlySky,
            out PathVertex v, out vec3 beyond) {
  uint what = translucentRays() | (path.fromEye && bounce == 0u ? 0u : kRayTwoSided);
  bool arrives = false;
  for (uint i = 0u; i <= kMaxCrossings && !rayWorkIsDone(); ++i) {
    RayHit hit = traceRay(frame, path.ray, what);
    float end = isHit(hit) ? hit.distance : 3.0e38;
    if (hasAreaLights(frame) && (bounce > 0u || path.covers))
      add(path, path.fromArea * areaRadiance(frame, path.ray, end, path.density, path.absorption), path.share,
          path.lambertian);
    if (!isHit(hit)) {
      if (hasCells(scene, frame) && (bounce > 0u || path.covers)) {
        float weight = path.density / (path.density + path.skies * skyDensity(frame, scene, path.ray.direction));
        add(path, path.carried * skyRadiance(frame, path.ray.direction) * weight, path.share, path.lambertian);
      }
      break;
    }
    vec3 kept = absorbed(path.absorption, end - path.ray.near);
    path.carried *= kept;
    path.fromArea *= kept;
    if (onlySky && (kPathFlags & kPathsFindTranslucent) == 0u) break;
    PathHit at = surfaceAt(frame, path.ray, hit);
    if (isInOwnPlane(path, at, hit, index)) break;
    disperse(path, at);
    v = vertexAt(at, -path.ray.direction, path.fromEye && bounce == 0u);
    beyond = absorptionBeyond(at, path.absorption);
    arrives = (kPathFlags & kPathsFindTranslucent) == 0u || !passes(path, at, v) || i == kMaxCrossings;
    if (arrives) path.covers = true;
    path.distance = hit.distance;
    float weight = path.density / (path.density + emitterDensity(scene, hit, at, path.ray.direction));
    vec3 emitted = at.s.emissive * (belowClearcoat(at.layers, path.ray.direction) * weight);
    if (arrives && !onlySky) add(path, path.carried * emitted, path.share, path.lambertian);
    path.deep = kSharedPaths != 0u && path.record.lobeDensity > 0.0;
    if (arrives && !onlySky && sharesSurface(path, at, index, i)) beginRecord(path, v, at.plane);
    if (arrives) break;
    path.absorption = beyond;
    path.ray.near = beyondHit(hit.distance);
  }
  return arrives && !onlySky;
}

// Chooses the direction in which a path leaves its surface, which is the `index`th one. Returns false if it ends there.
bool scatter(inout Path path, FrameConstants frame, PathVertex v, vec3 beyond, uint bounce, uint index) {
  vec3 toLight = nextDirection(v);
  float density = pathDensity(v, toLight);
  if (bounce == 0u && !path.fromEye) path.share = lobeShare(v, toLight);
  path.lambertian = recordedShare(path, v, toLight, bounce);
  vec3 reflected = pathReflectance(v, toLight, false) / max(density, 1e-30);
  // Emission of third surfaces is not shared, because its weight is that of this path's direction.
  if (kSharedPaths != 0u && path.recorded && index == 1u) {
    path.onward = reflected;
    path.record.onward = packSnorm2x16(octahedralFromDirection(toLight));
    path.record.lobeDensity = v.s.roughness >= kMinSharedRoughness ? density : 0.0;
    reflected = vec3(1.0);
  }
  path.fromArea = vec3(0.0);
  if (hasAreaLights(frame))
    path.fromArea = path.carried * (v.visible ? pathReflectance(v, toLight, true) / max(density, 1e-30) : reflected);
  path.carried *= reflected;
  float left = maxChannel(path.carried * path.onward * path.first), survives = index < 3u ? 1.0 : min(sqrt(left), 0.95);
  if (!(left > 0.0 && density > 0.0 && nextSample().x < survives)) return false;
  path.carried /= survives;
  path.fromArea /= survives;
  path.density = density;
  if (kLayers != 0u && dot(v.s.geonormal, toLight) < 0.0) path.absorption = beyond;
  path.ray = Ray(rayOrigin(v.s, toLight, path.distance), vec3(0.0), toLight, 0.0, 3.0e38);
  return true;
}

// Returns a path that starts at the eye, or at the visible surface, `fromEye` meters from it.
Path startPath(bool atEye, Ray ray, float fromEye) {
  Path path;
  path.sum = PathLight(vec3(0.0), vec3(0.0));
  path.carried = path.fromArea = vec3(1.0);
  path.share = vec3(atEye && kFiltered != 0u ? 1.0 : 0.0);
  path.absorption = vec3(0.0);
  path.ray = ray;
  path.density = kOnlyDirection;
  path.skies = 1.0;
  path.distance = fromEye;
  path.channel = kAllChannels;
  path.fromEye = atEye;
  path.covers = false;
  path.record = emptyRecord();
  path.recorded = false;
  path.recordAlbedo = vec3(1.0);
  path.first = vec3(1.0);
  path.lambertian = vec3(0.0);
  path.onward = vec3(1.0);
  path.deep = false;
  return path;
}

// Returns the path with its light. It starts at `v` unless it starts at the eye. The surfaces that a path meets inside
// a volume do not count as bounces, because all light that it follows has to leave the volume.
Path tracedPath(FrameConstants frame, Path path, PathVertex v) {
  const uint kMaxSurfaces = 128u;
  RayScene scene = loadRayScene(frame.rayScene);
  vec3 beyond = vec3(0.0);
  bool goesOn = true;
  uint bounce = 0u, i = 0u;
  do {
    if (goesOn && (i > 0u || ((kPathFlags & kPathsFromEye) != 0u && path.fromEye)))
      goesOn = follow(path, frame, scene, i, bounce, bounce > push.bounces, v, beyond);
    if (goesOn) {
      uint next = bounce + (kLayers != 0u && v.coated && v.coats.inside ? 0u : 1u);
      addDirectLight(path, frame, scene, v, beyond, bounce, next, i);
      goesOn = !endsAt(frame, next) && scatter(path, frame, v, beyond, bounce, i);
      bounce = next;
    }
  } while (++i < kMaxSurfaces && lanesGoOn(goesOn));
  return path;
}

void main() {
  bindSurfaces(push.frame, push.shown);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  if (!isOwnSky(frame, push.environment)) return;
  ivec3 place = ownPixel();
  emitterSums = push.emitterSums + uint64_t(place.z) * push.emitterStride * 4ul;
  View view = frameView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  LitPixel p = readPixel(frame, view, place, inside ? 1u : 0u);
  if (!inside) return;
  if ((kPathFlags & kPathsFromLights) != 0u) writeCounts(place, p.lit, vec4(0.0));
  EyeRay eye = eyeRay(frame, view, p);
  bool lit = p.lit && !eye.starts && reflects(p.s);
  PathSums sums = PathSums(vec4(0.0), vec4(0.0));
  if (kSharedPaths == 0u) sums = earlierSums(place);
#ifndef GBUFFER_NO_TARGETS
  p.s.geonormal = p.s.normal;  // most layouts do not store it
#endif
  PathVertex v = pathVertex(p.s, p.toEye, true);
  PathLight albedos = PathLight(vec3(1.0), vec3(1.0));
  if (kFiltered != 0u && !eye.starts) albedos = albedosOf(v);
  Path start = startPath(eye.starts, eye.ray, distance(p.s.position, view.eye));
  pathSeed = rayHash(floatBitsToUint(eye.starts ? eye.position : p.s.position)).x;
  const bool starts = lit || eye.starts;
  ivec2 size = imageSize(lightTarget).xy;
  for (uint i = push.first; !starts && kSharedPaths != 0u && i < push.end; ++i)
    PathRecordsRef(recordAddress(i, place, size)).v[0] = emptyRecord();
  if (starts) {
    uint i = push.first;
    do {
      pathIndex = push.firstPoint + i;
      pathPair = 0u;
      Path path = tracedPath(frame, start, v);
      if (kSharedPaths == 0u) {
        addSample(sums, path.sum, albedos, path.fromEye, path.covers);
      } else {
        path.record.reflected /= path.recordAlbedo;
        path.record.scattered = path.sum.scattered;
        path.record.mirrored = path.sum.mirrored;
        path.record.flags |= path.covers ? kRecordCovers : 0u;
        PathRecordsRef(recordAddress(i, place, size)).v[0] = path.record;
      }
    } while (++i < push.end);
  }
  if (kSharedPaths == 0u) writeSums(frame, place, p, albedos, sums, eye, lit);
}
