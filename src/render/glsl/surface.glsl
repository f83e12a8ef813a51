// Evaluates the Surface at a SurfacePoint from its material, for the geometry pass, the resolve and forward shading.
#ifndef LATELIGHT_SURFACE_GLSL
#define LATELIGHT_SURFACE_GLSL
#include "render/glsl/material.glsl"
#include "shared/surface.h"

// Returns the unperturbed normal, towards the viewer: the interpolated one, or the plane's if opposite normals cancel.
// (It does not call triangleNormal(), because every layout would then execute that function's loads, which cost more
// than the rest.)
vec3 vertexNormal(SurfacePoint p) {
  float squared = dot(p.normal, p.normal);
  float area = dot(p.plane, p.plane);
  if (squared > 1e-12) return p.normal * (p.facing * inversesqrt(squared));
  return area > 0.0 ? p.plane * inversesqrt(area) : vec3(0.0, 0.0, 1.0);
}

// Normal mapping in the vertices' tangent frame (glTF 2.0, section 3.9.3). `scale` multiplies the slopes of the map.
vec3 mappedNormal(Material m, uint slot, float scale, SurfacePoint p, vec3 n) {
  if (!hasTexture(m, slot)) return n;
  vec3 map = sampleTexture(m, slot, p).xyz * 2.0 - 1.0;
  vec3 tangent = p.tangent.xyz - n * dot(n, p.tangent.xyz);
  float squared = dot(tangent, tangent);
  if (squared < 1e-12) return n;  // no tangent frame
  vec3 t = tangent * inversesqrt(squared);
  vec3 b = cross(n * p.facing, t) * (p.tangent.w < 0.0 ? -1.0 : 1.0);
  map.xy *= scale;
  // On a back face the whole frame is flipped with the normal (glTF 2.0, section 3.9.1, doubleSided).
  vec3 mapped = p.facing * (t * map.x + b * map.y) + n * map.z;
  float length2 = dot(mapped, mapped);
  return length2 > 1e-24 ? mapped * inversesqrt(length2) : n;
}

// Returns the triangle's geometric normal from its vertices. It is exact even for small triangles, for which
// screen-space derivatives are not.
vec3 triangleNormal(FrameConstants frame, Instance instance, SurfacePoint p) {
  Mesh mesh = frameMesh(frame, p.mesh);
  uvec3 indices = triangleIndices(mesh, p.triangle);
  vec3 a = positionAt(mesh.positions, indices.x);
  // Edges are formed in object space: far from the world's origin the world positions of their ends differ only in the
  // last bits.
  vec3 ab = mat3(instance.objectToWorld) * (positionAt(mesh.positions, indices.y) - a);
  vec3 ac = mat3(instance.objectToWorld) * (positionAt(mesh.positions, indices.z) - a);
  vec3 extent = max(abs(ab), abs(ac));
  float scale = 1.0 / max(max(extent.x, max(extent.y, extent.z)), 1e-37);
  float winding = (instance.flags & kInstanceClockwise) != 0u ? -1.0 : 1.0;
  vec3 n = cross(ab * scale, ac * scale) * (winding * p.facing);
  float squared = dot(n, n);
  return squared > 0.0 ? n * inversesqrt(squared) : vec3(0.0, 0.0, 1.0);
}

Instance surfaceInstance(FrameConstants frame, SurfacePoint p) {
  Instance instance = frameInstance(frame, p.instance);
#ifdef DRAW_NUMBERS
  instance.id = varyingNumbers.x;
  instance.part = varyingNumbers.y;
#endif
  return instance;
}

float occlusionOf(Material m, vec4 texel) { return 1.0 + m.occlusionStrength * (texel.r - 1.0); }

Surface evaluateMaterial(FrameConstants frame, Material m, SurfacePoint p) {
  Instance instance = surfaceInstance(frame, p);
  Surface s = emptySurface();
  s.position = p.position;
  s.geonormal = triangleNormal(frame, instance, p);
  s.normal = mappedNormal(m, kTextureNormal, m.normalScale, p, vertexNormal(p));
  s.baseColor = baseColor(m, p).rgb;
  s.metallic = m.metallic;
  s.roughness = m.roughness;
  if (hasTexture(m, kTextureMetallicRoughness)) {
    vec4 t = sampleTexture(m, kTextureMetallicRoughness, p);
    s.metallic *= t.b;
    s.roughness *= t.g;
    if (allHave(kTraitSharedOcclusion) && hasTexture(m, kTextureOcclusion)) s.ao = occlusionOf(m, t);
  }
  if (!allHave(kTraitSharedOcclusion) && hasTexture(m, kTextureOcclusion))
    s.ao = occlusionOf(m, sampleTexture(m, kTextureOcclusion, p));
  s.emissive = m.emissive;
  if (hasTexture(m, kTextureEmissive)) s.emissive *= sampleTexture(m, kTextureEmissive, p).rgb;
  // KHR_materials_specular: f0 is tinted and capped at 1 before the weight scales both ends.
  float specular = allHave(kTraitPlainSpecular) ? 1.0 : m.specular;
  if (hasTexture(m, kTextureSpecular)) specular *= sampleTexture(m, kTextureSpecular, p).a;
  vec3 specularColor = allHave(kTraitPlainSpecular) ? vec3(1.0) : m.specularColor;
  if (hasTexture(m, kTextureSpecularColor)) specularColor *= sampleTexture(m, kTextureSpecularColor, p).rgb;
  s.f0 = min(m.f0 * specularColor, vec3(1.0)) * specular;
  s.f90 = specular;
  s.uv = p.uv.xy;
  s.id = instance.id;
  s.part = instance.part;
  s.material = m.id;
  s.flags = (m.flags & kMaterialUnlit) != 0u ? kSurfaceUnlit : 0u;
  if ((m.flags & kMaterialLayered) != 0u) s.flags = kSurfaceLayered;
  return s;
}

#endif
