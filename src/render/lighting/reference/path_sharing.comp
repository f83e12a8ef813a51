#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// functions: kept
// Pixels share their paths (Bekaert, Sbert and Halton 2002, Accelerating Path Tracing by Re-Using Paths). Each pixel of
// a group traces a path; then it connects its visible surface to the second surfaces of all these paths, which costs
// one shadow ray each, and receives the light that they reflect: by their Lambertian lobes, and that of lights and of
// third surfaces by their specular lobes.
//
// The balance heuristic combines the techniques by which the pixels could have found a surface, each with the density
// by which its pixel samples directions, if nothing blocks the connection (Veach and Guibas 1995). With these weights,
// the light of a surface is divided by the sum of all densities there, so the estimator is unbiased, and a connection
// contributes no more than the path that found the surface. For light that a specular lobe reflects of a third surface,
// densities are those of both directions.
//
// Pixels of a group are apart, so that neighbors have independent noise. Where lamps are, it has 64 pixels, because
// paths rarely find the bright surfaces around them; otherwise 32, and 16 before a filter, which removes most of what
// a larger group would. The highlights of lamps on metal close to them, such as their fixtures, have the most noise: a
// few paths find them. All pixels of the workgroup share these.
//
// Records are shared in rounds of kRound, first those of the groups and then those that glare.
//
// Inputs: the G-buffer, and the records of paths.comp. Outputs are those of paths.comp.
#define ONE_SAMPLE
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/rays.glsl"
#include "render/glsl/surface.glsl"
#include "render/lighting/reference/paths_push.h"

layout(push_constant, scalar) uniform Push { PathsPush push; };
layout(constant_id = kFilteredConstant) const uint kFiltered = 0;

#include "render/lighting/reference/path_record.glsl"
#include "render/lighting/reference/path_sums.glsl"

const uint kPixels = 2u * kPixelGroupX * kPixelGroupY;  // of a workgroup
const uint kRound = 16u;

// A group has every kStep-th pixel of a region of the workgroup.
const uvec2 kStep = uvec2(kFiltered != 0u ? 4u : 2u, 2u);
uvec2 region = uvec2(kPixelGroupX, kPixelGroupY);
uint groupSize() { return region.x / kStep.x * (region.y / kStep.y); }
uint groupRounds() { return groupSize() / kRound; }

shared float densities[kPixels * kRound];  // by pixel of the workgroup, and by record of a round
shared float densitySums[kPixels];         // of the pixel's record
shared float onwardSums[kPixels];          // the same, with the density of the direction onward
shared uint glaring[kPixels / 32u];        // a bit for each pixel whose record glares
shared uint glarers[kPixels];              // these pixels, in their order

uint indexOf(uvec2 place) { return place.y * kPixelGroupX + place.x; }

// Returns the index in the workgroup of a member of the group of a pixel.
uint memberIndex(uvec2 own, uint member) {
  uint side = region.x / kStep.x;
  return indexOf(own / region * region + own % kStep + kStep * uvec2(member % side, member / side));
}
uint memberOf(uvec2 own) {
  uvec2 place = own % region / kStep;
  return place.y * (region.x / kStep.x) + place.x;
}

// Lists the pixels whose records glare. Returns their number.
uint listGlarers(uint index, bool glares) {
  if (index < kPixels / 32u) glaring[index] = 0u;
  barrier();
  if (glares) atomicOr(glaring[index / 32u], 1u << (index % 32u));
  barrier();
  uint count = 0u, before = 0u;
  for (uint i = 0u; i < kPixels / 32u; ++i) {
    uint earlier = i < index / 32u ? ~0u : (i == index / 32u ? (1u << (index % 32u)) - 1u : 0u);
    before += uint(bitCount(glaring[i] & earlier));
    count += uint(bitCount(glaring[i]));
  }
  if (glares) glarers[before] = index;
  barrier();
  return count;
}

struct Round {
  uint index;
  bool ofGroup;  // records of the groups; otherwise, those that glare
  uint glarers;  // of all rounds
};

// Returns the pixel whose record is the `i`th one of a round, or kPixels.
uint recordPixel(Round round, uvec2 own, uint i) {
  uint first = round.index * kRound;
  if (round.ofGroup) return memberIndex(own, first + i);
  uint glarer = first - groupSize() + i;
  return glarer < round.glarers ? glarers[glarer] : kPixels;
}

// Adds the densities of all pixels that share a record, one record per invocation. Returns that record's pixel, or
// kPixels.
uint sumDensities(Round round, uvec2 own, out float sum) {
  uint index = indexOf(own), member = memberOf(own), pixel = kPixels;
  if (round.ofGroup && member / kRound == round.index) pixel = index;
  if (!round.ofGroup && index < kRound) pixel = recordPixel(round, own, index);
  uint column = round.ofGroup ? member % kRound : index;
  uint sharers = pixel == kPixels ? 0u : (round.ofGroup ? groupSize() : kPixels);
  sum = 0.0;
  for (uint i = 0u; i < sharers; ++i)
    sum += densities[(round.ofGroup ? memberIndex(own, i) : i) * kRound + column];
  return pixel;
}

// A connection from the visible surface to that of a record.
struct Connection {
  vec3 direction;
  float distance;
  float solidAngle;  // per area of the record's surface, 1/m^2
};

// `isOwn`: the pixel's path has found the surface.
Connection connectionTo(vec3 origin, PathRecord r, bool isOwn) {
  vec3 to = r.position - origin;
  float distance2 = max(dot(to, to), 1e-30), distance = sqrt(distance2);
  vec3 direction = to / distance;
  float cosine = -dot(recordPlane(r), direction);
  if (isOwn) cosine = max(cosine, 1e-4);
  else if (dot(recordNormal(r), direction) >= 0.0) cosine = 0.0;  // the shading normal would be another one
  return Connection(direction, distance, max(cosine, 0.0) / distance2);
}

// Returns the density with which the pixel finds the surface of a record, per area; 0 if the pixel cannot see it.
float recordDensity(FrameConstants frame, PathVertex v, vec3 origin, PathRecord r, bool isOwn) {
  Connection c = connectionTo(origin, r, isOwn);
  if (c.solidAngle <= 0.0 || !(maxChannel(pathReflectance(v, c.direction, false)) > 0.0)) return 0.0;
  float density = pathDensity(v, c.direction) * c.solidAngle;
  if (isOwn || density <= 0.0) return density;
  float far = c.distance - rayOffset(r.position, c.distance);
  Ray ray = Ray(origin, vec3(0.0), c.direction, 0.0, far);
  return isHit(traceRay(frame, ray, kRayTwoSided | kRayStopAtFirst | translucentRays())) ? 0.0 : density;
}

// Adds radiance that arrives through a connection.
void addConnection(inout PathLight sum, PathVertex v, Connection c, vec3 radiance) {
  radiance *= pathReflectance(v, c.direction, false) * c.solidAngle;
  vec3 mirrored = lobeShare(v, c.direction);
  sum.scattered += radiance * (1.0 - mirrored);
  sum.mirrored += radiance * mirrored;
}

// A visible surface, and the sample whose paths it shares.
struct Sharer {
  PathVertex v;
  vec3 origin;  // of its rays
  ivec3 place;  // its pixel
  uvec2 own;    // the same in the workgroup
  ivec2 size;   // of the image
  bool lit;
  uint sampleIndex;
};

// A pixel of the workgroup in the image.
ivec2 placeOf(Sharer s, uint pixel) {
  return s.place.xy - ivec2(s.own) + ivec2(pixel % kPixelGroupX, pixel / kPixelGroupX);
}
PathRecord recordOfPixel(Sharer s, uint pixel) {
  return recordAt(recordAddress(s.sampleIndex, ivec3(placeOf(s, pixel), s.place.z), s.size));
}

// Adds the light of the records of a round.
void addRound(inout PathLight light, FrameConstants frame, Sharer s, Round round) {
  uint index = indexOf(s.own);
  for (uint i = 0u; i < kRound; ++i) {
    uint pixel = recordPixel(round, s.own, i);
    float density = 0.0;
    if (s.lit && pixel < kPixels && all(lessThan(placeOf(s, pixel), s.size))) {
      PathRecord r = recordOfPixel(s, pixel);
      if (!round.ofGroup || isShared(r)) density = recordDensity(frame, s.v, s.origin, r, pixel == index);
    }
    densities[index * kRound + i] = density;
  }
  barrier();
  float sum;
  uint summed = sumDensities(round, s.own, sum), seen = 0u;
  if (summed < kPixels) densitySums[summed] = sum;
  barrier();
  for (uint i = 0u; i < kRound; ++i) {
    if (!(densities[index * kRound + i] > 0.0)) continue;
    seen |= 1u << i;
    uint pixel = recordPixel(round, s.own, i);
    PathRecord r = recordOfPixel(s, pixel);
    float density = r.lobeDensity;
    if (pixel != index && sharesLobe(r)) density = onwardDensity(r, normalize(s.origin - r.position));
    densities[index * kRound + i] *= density;
  }
  barrier();
  summed = sumDensities(round, s.own, sum);
  if (summed < kPixels) onwardSums[summed] = sum;
  barrier();
  for (uint i = 0u; i < kRound; ++i) {
    if ((seen >> i & 1u) == 0u) continue;
    uint pixel = recordPixel(round, s.own, i);
    PathRecord r = recordOfPixel(s, pixel);
    Connection c = connectionTo(s.origin, r, pixel == index);
    vec3 radiance;
    if (round.ofGroup) radiance = recordRadiance(r, -c.direction, vec2(densitySums[pixel], onwardSums[pixel]));
    else radiance = recordGlare(r, -c.direction) / densitySums[pixel];
    addConnection(light, s.v, c, radiance);
  }
  barrier();  // the next round writes densities
}

void main() {
  bindSurfaces(push.frame, push.shown);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  ivec3 place = ownPixel();
  uvec2 local = mortonPixel(gl_LocalInvocationID.x) + uvec2(0u, gl_LocalInvocationID.y * kPixelGroupY);
  View view = frameView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  LitPixel p = readPixel(frame, view, place, inside ? 1u : 0u);
  EyeRay eye = eyeRay(frame, view, p);
  bool lit = p.lit && !eye.starts && reflects(p.s);
#ifndef GBUFFER_NO_TARGETS
  p.s.geonormal = p.s.normal;  // most layouts do not store it
#endif
  PathVertex v = pathVertex(p.s, p.toEye, true);
  vec3 origin = p.s.position + p.s.geonormal * rayOffset(p.s.position, distance(p.s.position, view.eye));
  PathLight albedos = PathLight(vec3(1.0), vec3(1.0));
  if (kFiltered != 0u && !eye.starts) albedos = albedosOf(v);
  if (kFiltered == 0u && kLights != 0u && frame.lightCount > frame.directionalLights) region.y *= 2u;
  Sharer sharer = Sharer(v, origin, place, local, imageSize(lightTarget).xy, lit, push.first);
  PathSums sums = PathSums(vec4(0.0), vec4(0.0));
  if (inside) sums = earlierSums(place);
  do {  // tested at the end, because lavapipe would execute the body once more
    PathRecord own = emptyRecord();
    if (inside) own = recordOfPixel(sharer, indexOf(local));
    PathLight light = PathLight(own.scattered, own.mirrored);
    uint count = listGlarers(indexOf(local), glares(own)), rounds = groupRounds() + (count + kRound - 1u) / kRound;
    for (uint i = 0u; i < rounds; ++i) addRound(light, frame, sharer, Round(i, i < groupRounds(), count));
    if (inside) addSample(sums, light, albedos, eye.starts, (own.flags & kRecordCovers) != 0u);
  } while (++sharer.sampleIndex < push.end);
  if (inside) writeSums(frame, place, p, albedos, sums, eye, lit);
}
