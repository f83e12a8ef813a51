#version 460
#extension GL_GOOGLE_include_directive : require
// Casts rays from the host (push.rays) and writes the surface that each hits first (push.hits). The hit's distance is
// computed again in double-float arithmetic, from the ray's exact direction and the triangle's exact plane, so that it
// is precise on large triangles and at grazing angles.
#include "render/glsl/common.glsl"
#include "render/glsl/ray_point.glsl"
#include "render/glsl/surface.glsl"
#include "render/rays/cast_push.h"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer CastHitsRef { CastHit v[]; };

layout(push_constant, scalar) uniform Push { CastPush push; };

Exact3 exactCorner(Instance instance, Exact3 offset, vec3 position) {
  return add(transformed(mat3(instance.objectToWorld), exact(position)), offset);
}

float exactDistance(FrameConstants frame, Ray ray, vec3 directionLow, RayHit hit) {
  Instance instance = frameInstance(frame, hit.instance);
  uint64_t positions = MeshRef(frame.meshes).v[instance.mesh].positions;
  Exact3 offset = add(exactSum(instance.objectToWorld[3], -ray.origin),
                      exactSum(instance.translationLow, -ray.originLow));
  Exact3 a = exactCorner(instance, offset, positionAt(positions, hit.corners.x));
  Exact3 ab = subtract(exactCorner(instance, offset, positionAt(positions, hit.corners.y)), a);
  Exact3 ac = subtract(exactCorner(instance, offset, positionAt(positions, hit.corners.z)), a);
  // Scaled, so that the products stay within the range of floats.
  float scale = 1.0 / max(max(length(ab.hi), length(ac.hi)), 1e-37);
  Exact3 normal = crossOf(multiply(ab, exact(vec3(scale))), multiply(ac, exact(vec3(scale))));
  float across = rounded(dotOf(normal, Exact3(ray.direction, directionLow))).x;
  float distance = rounded(dotOf(normal, a)).x / across;
  // The plane of a sliver may be almost arbitrary, but a point of the triangle lies between its corners.
  vec3 along = vec3(dot(a.hi, ray.direction), dot(ab.hi, ray.direction), dot(ac.hi, ray.direction));
  along.yz += along.x;
  float slack = 1e-6 * max(length(a.hi), max(length(a.hi + ab.hi), length(a.hi + ac.hi)));
  float nearest = min(along.x, min(along.y, along.z)) - slack, farthest = max(along.x, max(along.y, along.z)) + slack;
  return across != 0.0 ? clamp(distance, nearest, farthest) : hit.distance;
}

// Returns the power that a Lambertian surface of the same reflectance sends back along the ray, relative to a white one
// that faces it: the cosine law. The reflectance is that of glTF's material at normal incidence, averaged over the
// channels because materials have no infrared.
float returnedIntensity(Surface s, vec3 direction) {
  vec3 reflectance = mix(s.f0 + (1.0 - s.f0) * s.baseColor, s.baseColor, s.metallic);
  float incidence = clamp(-dot(s.normal, direction), 0.0, 1.0);
  return (reflectance.r + reflectance.g + reflectance.b) / 3.0 * incidence;
}

CastHit hitOf(FrameConstants frame, Ray ray, vec3 directionLow, RayHit hit) {
  SurfacePoint p = rayPoint(frame, ray, hit);
  Surface s = evaluateMaterial(frame, frameMaterial(frame, frameInstance(frame, hit.instance).material), p);
  return CastHit(max(exactDistance(frame, ray, directionLow, hit), 0.0), s.id, s.part, s.material, s.normal,
                 hit.triangle, s.geonormal, hit.front ? 1u : 0u, s.uv, returnedIntensity(s, ray.direction), 0u);
}

void main() {
  uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x);
  if (index >= push.count) return;
  FrameConstants frame = FrameRef(push.frame).v;
  bindRayTextures(frame);
  uint64_t at = push.rays + uint64_t(index) * kCastRayBytes;
  vec4 origin = floatsAt(at, 0u), direction = floatsAt(at, 1u);
  Ray ray = Ray(origin.xyz, floatsAt(at, 2u).xyz, direction.xyz, origin.w, direction.w);
  RayHit hit = traceRay(frame, ray, push.what);
  CastHit result = CastHit(kRayInfinity, 0u, 0u, 0u, vec3(0.0), 0u, vec3(0.0), 0u, vec2(0.0), 0.0, 0u);
  for (bool some = isHit(hit); some; some = false) result = hitOf(frame, ray, floatsAt(at, 3u).xyz, hit);
  CastHitsRef(push.hits).v[index] = result;
}
