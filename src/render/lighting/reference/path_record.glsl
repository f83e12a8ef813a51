// The records by which pixels share paths (path_sharing.comp): the second surface of a path, and the light that leaves
// it toward the first one.
#ifndef LATELIGHT_PATH_RECORD_GLSL
#define LATELIGHT_PATH_RECORD_GLSL
#include "render/glsl/halves.glsl"
#include "render/lighting/reference/path_lobes.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PathRecordsRef { PathRecord v[]; };

uint64_t recordAddress(uint sampleIndex, ivec3 place, ivec2 size) {
  uint64_t pixels = uint64_t(size.x) * size.y * push.views;
  uint64_t pixel = (uint64_t(place.z) * size.y + place.y) * size.x + place.x;
  return push.records + (uint64_t(sampleIndex - push.first) * pixels + pixel) * kPathRecordBytes;
}
PathRecord recordAt(uint64_t address) { return PathRecordsRef(address).v[0]; }

// Describes the surface of a record. `reflected` is filled later.
PathRecord recordOf(PathVertex v, vec3 plane) {
  PathRecord r;
  r.position = v.s.position;
  r.reflected = r.lit = r.scattered = r.mirrored = r.received = vec3(0.0);
  r.normal = packSnorm2x16(octahedralFromDirection(v.s.normal));
  r.plane = packSnorm2x16(octahedralFromDirection(dot(plane, v.toEye) < 0.0 ? -plane : plane));
  r.toLight = r.flags = r.onward = 0u;
  r.lobeDensity = 0.0;
  r.f90 = v.s.f90;
  r.color = uint[2](packHalf2x16(v.s.baseColor.rg), packHalf2x16(vec2(v.s.baseColor.b, v.s.metallic)));
  r.specular = uint[2](packHalf2x16(v.s.f0.rg), packHalf2x16(vec2(v.s.f0.b, v.s.roughness)));
  return r;
}
PathRecord emptyRecord() {
  const vec3 none = vec3(0.0);
  return PathRecord(none, 0u, none, 0u, none, 0u, none, 0.0, none, uint[2](0u, 0u), uint[2](0u, 0u), 0u, none, 0u, 0.0);
}
// Filters remove what glare leaves.
bool glares(PathRecord r) { return kFiltered == 0u && (r.flags & kRecordGlares) != 0u; }
bool sharesLobe(PathRecord r) { return r.lobeDensity > 0.0 && maxChannel(r.received) > 0.0; }
bool isShared(PathRecord r) {
  return maxChannel(r.reflected) > 0.0 || (maxChannel(r.lit) > 0.0 && !glares(r)) || sharesLobe(r);
}

vec3 recordNormal(PathRecord r) { return directionFromOctahedral(unpackSnorm2x16(r.normal)); }
vec3 recordPlane(PathRecord r) { return directionFromOctahedral(unpackSnorm2x16(r.plane)); }

Surface recordSurface(PathRecord r) {
  Surface s = emptySurface();
  vec2 color = floatsFromHalves(r.color[1]), specular = floatsFromHalves(r.specular[1]);
  s.normal = recordNormal(r);
  s.baseColor = vec3(floatsFromHalves(r.color[0]), color.x);
  s.metallic = color.y;
  s.f0 = vec3(floatsFromHalves(r.specular[0]), specular.x);
  s.roughness = specular.y;
  s.f90 = r.f90;
  return s;
}

// The albedo of the Lambertian lobe, which depends on the direction because the specular lobe reflects some light
// before.
vec3 recordAlbedo(Surface s, vec3 toEye) {
  if (pathShading() == kShadingBlinnPhong) return vec3(1.0);
  vec2 at = vec2(clamp(dot(s.normal, toEye), 0.0, 1.0), s.roughness);
  return surfaceReflectance(s, extrapolatedSplitSum(at)).scattered + vec3(1e-5);
}

// The radiance that the specular lobe of a record's surface reflects of a light.
vec3 recordLobe(Surface s, vec3 toEye, uint toLight, vec3 intensity) {
  SurfaceBrdf lobe = surfaceBrdf(s, toEye, pathShading());
  lobe.diffuse = vec3(0.0);
  return shadeLight(lobe, LightSample(directionFromOctahedral(unpackSnorm2x16(toLight)), intensity, 1.0), pathShading());
}
vec3 recordGlare(PathRecord r, vec3 toEye) { return recordLobe(recordSurface(r), toEye, r.toLight, r.lit); }

// The density, 1/sr, with which a path from this side would go on as the record's does.
float onwardDensity(PathRecord r, vec3 toEye) {
  PathVertex v = pathVertex(recordSurface(r), toEye, false);
  return pathDensity(v, directionFromOctahedral(unpackSnorm2x16(r.onward)));
}

// The radiance that the surface of a record sends in a direction, but no glare. `densities`: with which pixels find the
// surface, and also the direction onward.
vec3 recordRadiance(PathRecord r, vec3 toEye, vec2 densities) {
  Surface s = recordSurface(r);
  vec3 radiance = r.reflected * recordAlbedo(s, toEye);
  if (maxChannel(r.lit) > 0.0 && !glares(r)) radiance += recordLobe(s, toEye, r.toLight, r.lit);
  radiance /= densities.x;
  if (sharesLobe(r)) radiance += recordLobe(s, toEye, r.onward, r.received) / densities.y;
  return radiance;
}

#endif
