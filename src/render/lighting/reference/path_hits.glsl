// The surfaces that rays of paths hit, and the light that passes them straight on: blended surfaces by their alpha, and
// smooth thin walls. Rays to lights pass these, attenuated. All other transmissive surfaces block rays to lights, and
// light passes them along paths only.
#ifndef LATELIGHT_PATH_HITS_GLSL
#define LATELIGHT_PATH_HITS_GLSL
#include "render/lighting/reference/path_eye.glsl"
#include "render/lighting/reference/path_lobes.glsl"

// Surfaces that a ray passes straight on. It ends after them.
const uint kMaxCrossings = 128u;

// The surface that a ray hits.
struct PathHit {
  Surface s;
  SurfaceLayers layers;
  vec3 plane;   // unit normal of the triangle
  float area;   // of the triangle, m^2
  uint flags;   // kMaterial*
  float alpha;  // fraction of the light behind it that a blended surface replaces
  bool front;   // the ray comes from the front side
  bool flipped; // the shading normal was on the other side of the ray
};

PathHit surfaceAt(FrameConstants frame, Ray ray, RayHit hit) {
  SurfacePoint p = rayPoint(frame, ray, hit);
  uint material = frameInstance(frame, hit.instance).material;
  Material m = frameMaterial(frame, material);
  fetchTexels(frame, material, p, ~0u);
  PathHit at;
  at.s = evaluateMaterial(frame, m, p);
  at.s.flags &= ~kSurfaceLayered;
  at.layers = emptyLayers();
  at.flags = m.flags;
  if (kLayers != 0u && (m.flags & kMaterialLayered) != 0u) at.layers = evaluateLayers(frame, m, p, at.s);
  at.alpha = (m.flags & kMaterialBlended) != 0u ? clamp(baseColor(m, p).a, 0.0, 1.0) : 1.0;
  at.front = hit.front;
  // Both normals on the side that the ray comes from.
  at.flipped = dot(at.s.normal, ray.direction) >= 0.0;
  if (at.flipped) at.s.normal = at.s.geonormal;
  bool unlit = (at.s.flags & kSurfaceUnlit) != 0u;
  if (unlit) at.s.emissive = at.s.baseColor;
  if (unlit) at.s = withoutReflection(at.s);
  if ((m.flags & kMaterialMasked) != 0u && masked(m, p)) at.s.emissive = vec3(0.0);
  at.area = 0.5 * length(p.plane);
  at.plane = p.plane / max(2.0 * at.area, 1e-30);
  return at;
}

PathVertex vertexAt(PathHit at, vec3 toEye, bool visible) {
  PathVertex v = pathVertex(at.s, toEye, visible);
  if (kLayers == 0u) return v;
  v.coated = (at.flags & kMaterialLayered) != 0u;
  v.coats = coatedVertex(at.s, at.layers, toEye, at.front);
  return v;
}

// The fraction of the emission below a clearcoat that leaves it in a direction.
float belowClearcoat(SurfaceLayers l, vec3 direction) {
  if ((kLayers & kLayerClearcoat) == 0u || l.clearcoat <= 0.0) return 1.0;
  float cosine = clamp(abs(dot(l.clearcoatNormal, direction)), kMinNv, 1.0);
  return 1.0 - saturate(l.clearcoat) * (0.04 + 0.96 * schlickWeight(cosine));
}

// --- volumes ---------------------------------------------------------------------------------------------------------

// The absorption on the other side of a surface, in 1/m.
vec3 absorptionBeyond(PathHit at, vec3 before) {
  if (at.layers.thickness <= 0.0) return before;
  return at.front ? at.layers.absorption : vec3(0.0);
}

// A ray that leaves the scene inside a volume has left through a hole of its mesh.
vec3 absorbed(vec3 absorption, float distance) {
  return distance < 1.0e30 ? beersLaw(absorption, max(distance, 0.0)) : vec3(1.0);
}

// --- rays to lights --------------------------------------------------------------------------------------------------

float beyondHit(float distance) { return distance * 1.000002 + 1e-7; }

// Returns the fraction of light that the surface at a hit lets pass straight on, and the absorption after it.
vec3 passedStraight(FrameConstants frame, Ray ray, RayHit hit, inout vec3 absorption) {
  PathHit at = surfaceAt(frame, ray, hit);
  vec3 straight = vec3(0.0);
  if (kLayers != 0u && passesStraight(at.s, at.layers)) {
    LayeredBrdf b = pathBrdf(at.s, at.layers, -ray.direction);
    straight = b.seen * b.under;
  }
  absorption = absorptionBeyond(at, absorption);
  return vec3(1.0) + (straight - vec3(1.0)) * at.alpha;
}

// Returns the fraction of light that arrives through a ray. `absorption`: at its origin.
vec3 lightPassed(FrameConstants frame, Ray ray, vec3 absorption) {
  if ((kPathFlags & kPathsFindTranslucent) == 0u)  // no loop, whose body lavapipe would execute once more
    return rayWorkIsDone() || isBlocked(frame, ray) ? vec3(0.0) : absorbed(absorption, ray.far - ray.near);
  vec3 passed = vec3(1.0);
  bool ends = false;
  for (uint i = 0u; i <= kMaxCrossings && !ends; ++i) {
    if (rayWorkIsDone()) return vec3(0.0);
    RayHit hit = traceRay(frame, ray, kRayTwoSided | kRayAnySurface);
    ends = !isHit(hit);
    passed *= absorbed(absorption, (ends ? ray.far : hit.distance) - ray.near);
    if (ends) break;
    passed *= i < kMaxCrossings ? passedStraight(frame, ray, hit, absorption) : vec3(0.0);
    ray.near = beyondHit(hit.distance);
    ends = maxChannel(passed) <= 0.0;
  }
  return passed;
}

#endif
