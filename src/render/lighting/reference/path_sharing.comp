#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// functions: kept
// Pixels share their paths (Bekaert, Sbert and Halton 2002, Accelerating Path Tracing by Re-Using Paths). A group of
// kGroup pixels traces a path each; every pixel then connects its visible surface to the second surfaces of all these
// paths, which costs one shadow ray each, and receives the light that they reflect by their Lambertian lobes, and the
// light of lights that they reflect by their specular lobes.
//
// The balance heuristic combines the kGroup techniques by which the pixels could have found a surface, each with the
// density by which its pixel samples directions, if nothing blocks the connection (Veach and Guibas 1995). With these
// weights, the light of a surface is divided by the sum of all densities there, so the estimator is unbiased, and a
// connection contributes no more than the path that found the surface. Pixels of a group are apart, so that neighbors
// have independent noise. A filter removes most of what a larger group would, so groups are smaller with it.
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

const uint kStepX = kFiltered != 0u ? 4u : 2u, kStepY = 2u;  // between the pixels of a group
const uint kSideX = kPixelGroupX / kStepX, kSideY = kPixelGroupY / kStepY;
const uint kGroup = kSideX * kSideY;
const uint kPixels = kPixelGroupX * kPixelGroupY;

shared float densities[kPixels * kGroup];  // by pixel of the workgroup, and by member of its group
shared float densitySums[kPixels];

// Returns a member's position in the workgroup. `own`: that of a pixel of the group.
uvec2 memberPlace(uvec2 own, uint member) {
  const uvec2 step = uvec2(kStepX, kStepY);
  return own % step + step * uvec2(member % kSideX, member / kSideX);
}
uint memberOf(uvec2 own) { return own.y / kStepY * kSideX + own.x / kStepX; }
uint indexOf(uvec2 place) { return place.y * kPixelGroupX + place.x; }

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

// Adds the light that the surface of a record sends through a connection.
void addConnection(inout PathLight sum, PathVertex v, vec3 origin, PathRecord r, bool isOwn, float densitySum) {
  Connection c = connectionTo(origin, r, isOwn);
  vec3 radiance = recordRadiance(r, -c.direction) * pathReflectance(v, c.direction, false) * (c.solidAngle / densitySum);
  vec3 mirrored = lobeShare(v, c.direction);
  sum.scattered += radiance * (1.0 - mirrored);
  sum.mirrored += radiance * mirrored;
}

void main() {
  bindSurfaces(push.frame, push.shown);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  ivec3 place = ownPixel();
  uvec2 local = mortonPixel(gl_LocalInvocationIndex);
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
  ivec2 size = imageSize(lightTarget).xy;
  uint index = indexOf(local), self = memberOf(local);
  PathSums sums = PathSums(vec4(0.0), vec4(0.0));
  if (inside) sums = earlierSums(place);
  uint i = push.first;
  do {  // tested at the end, because lavapipe would execute the body once more
    barrier();  // the densities may still be read, for the sample before
    for (uint member = 0u; member < kGroup; ++member) {
      ivec3 other = ivec3(place.xy - ivec2(local) + ivec2(memberPlace(local, member)), place.z);
      float density = 0.0;
      if (lit && all(lessThan(other.xy, size))) {
        PathRecord r = recordAt(recordAddress(i, other, size));
        if (isShared(r)) density = recordDensity(frame, v, origin, r, member == self);
      }
      densities[index * kGroup + member] = density;
    }
    barrier();
    float sum = 0.0;
    for (uint member = 0u; member < kGroup; ++member)
      sum += densities[indexOf(memberPlace(local, member)) * kGroup + self];
    densitySums[index] = sum;
    barrier();
    if (inside) {
      PathRecord own = recordAt(recordAddress(i, place, size));
      PathLight light = PathLight(own.scattered, own.mirrored);
      for (uint member = 0u; member < kGroup; ++member) {
        if (densities[index * kGroup + member] > 0.0) {
          uvec2 at = memberPlace(local, member);
          PathRecord r = recordAt(recordAddress(i, ivec3(place.xy - ivec2(local) + ivec2(at), place.z), size));
          addConnection(light, v, origin, r, member == self, densitySums[indexOf(at)]);
        }
      }
      addSample(sums, light, albedos, eye.starts, own.covers != 0u);
    }
  } while (++i < push.end);
  if (inside) writeSums(frame, place, p, albedos, sums, eye, lit);
}
