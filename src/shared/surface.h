// Surface: everything that a G-buffer may store about the visible point of a pixel. Every layout packs and unpacks it;
// every lighting technique shades it. World space (Z up), linear Rec.709, meters.
#ifndef LATELIGHT_SHARED_SURFACE_H
#define LATELIGHT_SHARED_SURFACE_H

#include "shared/lang.h"

SH_BEGIN

struct Surface {
  vec3 position;
  vec3 normal;     // unit, including the normal map, on the viewer's side of the surface
  vec3 geonormal;  // unit normal of the triangle
  vec3 baseColor;
  float metallic;
  float roughness;  // perceptual: alpha = roughness^2
  vec3 f0;          // reflectance of the dielectric at normal incidence, [0, 1]
  float f90;        // reflectance of the dielectric at grazing incidence: KHR_materials_specular's weight
  vec3 emissive;
  vec3 scattered;  // stored in no layout: surfaceReflectance() of shade.h, for kShadingGgxCompensated
  float ao;        // 1: unoccluded
  float sun;       // unshadowed fraction of the sun's light, in layouts with GBUFFER_SUN_TARGET; otherwise 1
  vec2 uv;         // UV set 0
  vec2 motion;     // pixels, y down, without jitter: to the position in the previous frame
  uint id;         // ids of the node or its group, the part and the material (shared/types.h); 0: background
  uint part;
  uint material;
  uint flags;  // kSurface*
};
SH_CONST uint kSurfaceUnlit = 1u;    // KHR_materials_unlit: outputs its baseColor
SH_CONST uint kSurfaceLayered = 2u;  // render/layered adds its light; lighting techniques treat it as neither
                                     // reflective nor emissive

SH_FUNC Surface emptySurface() {
  Surface s;
  s.position = vec3(0.0f, 0.0f, 0.0f);
  s.normal = vec3(0.0f, 0.0f, 1.0f);
  s.geonormal = vec3(0.0f, 0.0f, 1.0f);
  s.baseColor = vec3(0.0f, 0.0f, 0.0f);
  s.metallic = 0.0f;
  s.roughness = 1.0f;
  s.f0 = vec3(0.0f, 0.0f, 0.0f);
  s.f90 = 0.0f;
  s.emissive = vec3(0.0f, 0.0f, 0.0f);
  s.scattered = vec3(0.0f, 0.0f, 0.0f);
  s.ao = 1.0f;
  s.sun = 1.0f;
  s.uv = vec2(0.0f, 0.0f);
  s.motion = vec2(0.0f, 0.0f);
  s.id = 0u;
  s.part = 0u;
  s.material = 0u;
  s.flags = 0u;
  return s;
}

// c_diff of the glTF 2.0 specification, appendix B: metals have none.
SH_FUNC vec3 diffuseColor(Surface s) {
  return s.baseColor * (1.0f - s.metallic);
}

// f0 of the glTF 2.0 specification, appendix B: dielectric and metal mixed by metalness.
SH_FUNC vec3 specularF0(Surface s) {
  return s.f0 + (s.baseColor - s.f0) * s.metallic;
}

// Grazing reflectance of the mix. A metal's is 1.
SH_FUNC float specularF90(Surface s) {
  return s.f90 + (1.0f - s.f90) * s.metallic;
}

// Returns a copy of the surface that reflects nothing.
SH_FUNC Surface withoutReflection(Surface s) {
  s.baseColor = vec3(0.0f, 0.0f, 0.0f);
  s.metallic = 0.0f;
  s.f0 = vec3(0.0f, 0.0f, 0.0f);
  s.f90 = 0.0f;
  return s;
}

// True if the surface reflects any light.
SH_FUNC bool reflects(Surface s) {
  return specularF90(s) > 0.0f || dot(s.baseColor + s.f0, vec3(1.0f, 1.0f, 1.0f)) > 0.0f;
}

// The surface as lighting techniques light it: unlit and layered surfaces reflect nothing.
SH_FUNC Surface litSurface(Surface s) {
  if (s.flags != 0u) return withoutReflection(s);
  return s;
}

// The radiance that lighting techniques add for emission.
SH_FUNC vec3 emittedRadiance(Surface s) {
  if ((s.flags & kSurfaceLayered) != 0u) return vec3(0.0f, 0.0f, 0.0f);
  if ((s.flags & kSurfaceUnlit) != 0u) return s.baseColor;
  return s.emissive;
}

SH_END

#endif
