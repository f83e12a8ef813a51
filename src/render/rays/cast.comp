#version 460
#extension GL_GOOGLE_include_directive : require
// Casts rays, through the scene or its worlds, and writes the surface that each hits first. Rays are doubles, or
// floats, in the frame of the caller; they are converted to pairs of floats in the device's world space here, so the
// host only copies them. Rays that begin far outside the scene are traced from a point near it: along a direction of
// floats, they would pass the surface at a distance that grows with that of the origin. The hit's distance is computed
// again in double precision, from the ray's exact direction and the triangle's exact plane, so that it is precise on
// large triangles and at grazing angles.
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/float_rounding.glsl"
#include "render/glsl/ray_point.glsl"
#include "render/glsl/surface.glsl"
#include "render/rays/cast_push.h"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer DoublesRef { double v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatsRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer FloatsOutRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer UintsOutRef { uint v[]; };

layout(push_constant, scalar) uniform Push { CastPush push; };

dvec3 doublesAt(uint64_t array, uint index) {
  DoublesRef all = DoublesRef(array);
  return dvec3(all.v[3u * index], all.v[3u * index + 1u], all.v[3u * index + 2u]);
}

// Returns the distance from the ray's origin at which the ray `along` meets the plane of the triangle.
double exactDistance(FrameConstants frame, Ray ray, dvec3 along, RayHit hit) {
  Instance instance = frameInstance(frame, hit.instance);
  uint64_t positions = meshPositions(frame, instance.mesh);
  dmat3 axes = dmat3(mat3(instance.objectToWorld));
  dvec3 offset = (dvec3(instance.objectToWorld[3]) - widened(ray.origin)) +
                 (dvec3(instance.translationLow) - dvec3(ray.originLow));
  dvec3 a = axes * dvec3(positionAt(positions, hit.corners.x)) + offset;
  dvec3 b = axes * dvec3(positionAt(positions, hit.corners.y)) + offset;
  dvec3 c = axes * dvec3(positionAt(positions, hit.corners.z)) + offset;
  dvec3 normal = cross(b - a, c - a);
  double across = dot(normal, along), distance = dot(normal, a) / across;
  // The plane of a sliver may be almost arbitrary, but a point of the triangle lies between its corners.
  dvec3 places = dvec3(dot(a, along), dot(b, along), dot(c, along));
  double slack = 1e-6lf * max(length(a), max(length(b), length(c)));
  double nearest = min(places.x, min(places.y, places.z)) - slack;
  double farthest = max(places.x, max(places.y, places.z)) + slack;
  return across != 0.0lf ? clamp(distance, nearest, farthest) : double(hit.distance);
}

// Returns the power that a Lambertian surface of the same reflectance sends back along the ray, relative to a white one
// that faces it: the cosine law. The reflectance is that of glTF's material at normal incidence, averaged over the
// channels because materials have no infrared.
float returnedIntensity(Surface s, vec3 direction) {
  vec3 reflectance = mix(s.f0 + (1.0 - s.f0) * s.baseColor, s.baseColor, s.metallic);
  float incidence = clamp(-dot(s.normal, direction), 0.0, 1.0);
  return (reflectance.r + reflectance.g + reflectance.b) / 3.0 * incidence;
}

// A point or direction of the rays' frame in the renderer's world, and back.
dvec3 toWorld(dvec3 v) { return (push.flags & kCastFileAxes) != 0u ? dvec3(v.x, -v.z, v.y) : v; }
vec3 toFrame(vec3 v) { return (push.flags & kCastFileAxes) != 0u ? vec3(v.x, v.z, -v.y) : v; }

dvec3 vectorAt(uint64_t array, uint index) {
  if ((push.flags & kCastDoubles) != 0u) return doublesAt(array, index);
  return dvec3(FloatsRef(array).v[3u * index], FloatsRef(array).v[3u * index + 1u], FloatsRef(array).v[3u * index + 2u]);
}

bool isFinite(dvec3 v) {
  const double kLargest = 1.7976931348623157e308lf;
  return abs(v.x) <= kLargest && abs(v.y) <= kLargest && abs(v.z) <= kLargest;
}

// Returns the unit vector of a direction of any length; not finite for directions without one. Squares of the quotient
// neither overflow nor underflow.
dvec3 unitOf(dvec3 direction) {
  double largest = max(max(abs(direction.x), abs(direction.y)), abs(direction.z));
  precise dvec3 scaled = direction / largest;
  precise double squared = scaled.x * scaled.x + scaled.y * scaled.y + scaled.z * scaled.z;
  precise dvec3 unit = scaled / sqrt(squared);
  return unit;
}

vec3 remainderOf(dvec3 v) { return vec3(v - roundedToFloat(v)); }

void store(uint64_t array, uint index, float value) {
  if (array != 0ul) FloatsOutRef(array).v[index] = value;
}
void store(uint64_t array, uint index, vec3 value) {
  if (array == 0ul) return;
  for (uint i = 0u; i < 3u; ++i) FloatsOutRef(array).v[3u * index + i] = value[i];
}
void store(uint64_t array, uint index, uint value) {
  if (array != 0ul) UintsOutRef(array).v[index] = value;
}

// Returns a distance from the origin within which no ray can hit the scene; 0 for origins near or in the scene. The
// ray from there on is no longer than two diagonals of the scene's bounds.
double emptyDistance(FrameConstants frame, dvec3 origin) {
  RayScene scene = loadRayScene(frame.rayScene);
  if (scene.instanceCount == 0u) return 0.0lf;
  RayNode root = loadRayNode(scene.nodes);
  bool both = root.b != kRayNone;
  dvec3 low = dvec3(both ? min(root.lowA, root.lowB) : root.lowA);
  dvec3 high = dvec3(both ? max(root.highA, root.highB) : root.highA);
  double toBounds = length(max(max(low - origin, origin - high), dvec3(0.0lf))), diagonal = length(high - low);
  return toBounds > diagonal ? toBounds - diagonal : 0.0lf;
}

// Stores what the ray hits, in the frame of the rays. `skipped`: the distance from `origin` to that of `ray`. The
// position follows from the ray in double precision, so it is as precise as the distance.
void storeHit(FrameConstants frame, uint index, Ray ray, dvec3 along, RayHit hit, dvec3 origin, dvec3 unit,
              double skipped) {
  SurfacePoint p = rayPoint(frame, ray, hit);
  uint material = frameInstance(frame, hit.instance).material;
  fetchTexels(frame, material, p, ~0u);
  Surface s = evaluateMaterial(frame, frameMaterial(frame, material), p);
  double distance = skipped + max(exactDistance(frame, ray, along, hit), 0.0lf);
  precise dvec3 position = (origin - doublesAt(push.numbers, 1u)) + unit * distance;
  store(push.distance, index, float(distance));
  store(push.position, index, vec3(position));
  store(push.normal, index, toFrame(s.normal));
  store(push.geonormal, index, toFrame(s.geonormal));
  store(push.uv, 2u * index, s.uv.x);
  store(push.uv, 2u * index + 1u, s.uv.y);
  store(push.id, index, s.id);
  store(push.part, index, s.part);
  store(push.material, index, s.material);
  store(push.triangle, index, hit.triangle);
  store(push.intensity, index, returnedIntensity(s, ray.direction));
}

void storeMiss(uint index) {
  store(push.distance, index, kRayInfinity);
  store(push.position, index, vec3(0.0));
  store(push.normal, index, vec3(0.0));
  store(push.geonormal, index, vec3(0.0));
  store(push.uv, 2u * index, 0.0);
  store(push.uv, 2u * index + 1u, 0.0);
  store(push.id, index, 0u);
  store(push.part, index, 0u);
  store(push.material, index, 0u);
  store(push.triangle, index, 0u);
  store(push.intensity, index, 0.0);
}

void main() {
  uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x);
  if (index >= push.count) return;
  FrameConstants frame = FrameRef(push.frame).v;
  uint world = index / push.perWorld;
  frame.instances += uint64_t(world) * push.instanceCount * kInstanceBytes;
  frame.rayScene += uint64_t(world) * kRaySceneBytes;
  dvec3 origin = vectorAt(push.origins, index), unit = unitOf(vectorAt(push.directions, index));
  precise dvec3 from = toWorld(origin) - doublesAt(push.numbers, 0u);
  dvec3 along = toWorld(unit);
  bool valid = isFinite(from) && isFinite(along);
  double skipped = valid ? emptyDistance(frame, from) : 0.0lf;
  precise dvec3 start = from + along * skipped;
  const double kLargest = 3.4028234663852886e38lf;
  float far = float(min(DoublesRef(push.numbers).v[6] - skipped, kLargest));
  Ray ray = Ray(vec3(start), remainderOf(start), vec3(along), valid ? 0.0 : 1.0, valid ? far : 0.0);
  RayHit hit = traceRay(frame, ray, push.flags & kRayAnySurface);
  if (isHit(hit)) storeHit(frame, index, ray, along, hit, origin, unit, skipped);
  else storeMiss(index);
}
