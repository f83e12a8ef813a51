// The SurfacePoint that a ray hits, and the material textures there. A ray has no footprint, so textures are sampled
// from level 0.
#ifndef LATELIGHT_RAY_POINT_GLSL
#define LATELIGHT_RAY_POINT_GLSL
#include "render/glsl/material.glsl"
#include "render/glsl/rays.glsl"
#include "render/glsl/vertex_directions.glsl"

SurfacePoint rayPoint(FrameConstants frame, Ray ray, RayHit hit) {
  Instance instance = frameInstance(frame, hit.instance);
  Mesh mesh = frameMesh(frame, instance.mesh);
  precise vec3 offset = (instance.objectToWorld[3] - ray.origin) + (instance.translationLow - ray.originLow);
  VertexDirections directions = vertexDirections(instance);
  SurfacePoint p;
  vec3 corners[3];  // relative to the ray's origin
  vec3 relative = vec3(0.0);
  vec2 uv = vec2(0.0);
  vec4 tangent = vec4(0.0);
  p.normal = vec3(0.0);
  for (int i = 0; i < 3; ++i) {
    VertexAttributes a = attributesAt(mesh.attributes, hit.corners[i]);
    corners[i] = mat3(instance.objectToWorld) * positionAt(mesh.positions, hit.corners[i]) + offset;
    relative += hit.weights[i] * corners[i];
    p.normal += hit.weights[i] * worldNormal(directions, a.normal);
    tangent += hit.weights[i] * a.tangent;
    uv += hit.weights[i] * a.uv0;
  }
  p.position = ray.origin + relative;
  p.tangent = worldTangent(directions, tangent);
  p.uv = vec4(uv, uv);
  p.color = vec4(1.0);
  if (hasExtras(instance)) {
    p.uv.zw = vec2(0.0);
    p.color = vec4(0.0);
    for (int i = 0; i < 3; ++i) {
      VertexExtra extra = ExtraRef(mesh.extras).v[hit.corners[i]];
      p.uv.zw += hit.weights[i] * extra.uv1;
      p.color += hit.weights[i] * extra.color;
    }
  }
  p.facing = hit.front ? 1.0 : -1.0;
  p.plane = cross(corners[1] - corners[0], corners[2] - corners[0]) * p.facing;
  if ((instance.flags & kInstanceClockwise) != 0u) p.plane = -p.plane;
  p.instance = hit.instance;
  p.mesh = instance.mesh;
  p.triangle = hit.triangle;
#ifdef LATELIGHT_SURFACE_POINT_GLSL
  uvRight = uvDown = vec4(0.0);
#endif
  return p;
}

// Call fetchTexels() before a material is evaluated at the point: it fetches the texels of these texture slots, which
// sampleTexture() then returns.
#ifdef LATELIGHT_SURFACE_POINT_GLSL  // which defines sampleTexture()
void fetchTexels(FrameConstants frame, uint material, SurfacePoint p, uint slots) {}
#else
// A loop with one call: drivers inline calls, and calls wherever a texture is used made up almost half of a path's
// code.
vec4 rayTexels[kTextureCount];
void fetchTexels(FrameConstants frame, uint material, SurfacePoint p, uint slots) {
  uint64_t at = frame.materials + uint64_t(material) * kMaterialBytes;
  bool plain = (sceneWordAt(at, kMaterialFlagsAt) & kMaterialPlainUv) != 0u;
  uint left = sceneWordAt(at, kMaterialTexturesAt) & kTextureSlots & slots;
  do {
    if (left != 0u) {
      uint slot = uint(findLSB(left));
      vec2 uv = p.uv.xy;
      if (!plain) uv = transformedUv(textureTransform(at, slot), p.uv);
      rayTexels[slot] = magnifiedTexture(textureAt(frame.textures, sceneWordAt(at, kMaterialImagesAt + slot)), uv);
      left &= left - 1u;
    }
  } while (lanesGoOn(left != 0u));
}
vec4 sampleTexture(Material m, uint slot, SurfacePoint p) { return rayTexels[slot]; }
#endif

#endif
