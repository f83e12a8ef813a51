// Evaluates the coats of a layered material (KHR_materials_*) at a surface point. Include after surface.glsl.
#include "shared/layers.h"

// FrameConfig::layers, the coats that any material of the scene has. The specialization constant removes code for all
// others.
layout(constant_id = kLayersConstant) const uint kLayers = ~0u;

// The direction of anisotropy (KHR_materials_anisotropy): the vertex tangent projected to the plane of the normal,
// rotated by the material and its texture (`turned`: cosine and sine). Without a tangent frame it is an arbitrary
// direction in the plane.
vec3 stretchDirection(SurfacePoint p, vec3 n, vec2 turned) {
  vec3 tangent = p.tangent.xyz - n * dot(n, p.tangent.xyz);
  float squared = dot(tangent, tangent);
  vec3 any = abs(n.z) < 0.9 ? vec3(-n.y, n.x, 0.0) : vec3(0.0, -n.z, n.y);
  vec3 t = squared > 1e-12 ? tangent * inversesqrt(squared) : normalize(any);
  vec3 b = cross(n * p.facing, t) * (p.tangent.w < 0.0 ? -1.0 : 1.0);
  return normalize(t * turned.x + b * turned.y);
}

void findAnisotropy(inout SurfaceLayers l, Material m, SurfacePoint p, vec3 n) {
  vec2 turned = vec2(cos(m.layers.anisotropyRotation), sin(m.layers.anisotropyRotation));
  l.anisotropy = m.layers.anisotropy;
  if (hasTexture(m, kTextureAnisotropy)) {
    vec3 map = sampleTexture(m, kTextureAnisotropy, p).xyz;
    vec2 way = map.xy * 2.0 - 1.0;
    turned = vec2(turned.x * way.x - turned.y * way.y, turned.y * way.x + turned.x * way.y);
    if (dot(turned, turned) < 1e-6) turned = vec2(1.0, 0.0);
    l.anisotropy *= map.z;
  }
  l.anisotropyDirection = stretchDirection(p, n, turned);
}

void findClearcoat(inout SurfaceLayers l, Material m, SurfacePoint p) {
  l.clearcoat = m.layers.clearcoat;
  if (hasTexture(m, kTextureClearcoat)) l.clearcoat *= sampleTexture(m, kTextureClearcoat, p).r;
  l.clearcoatRoughness = m.layers.clearcoatRoughness;
  if (hasTexture(m, kTextureClearcoatRoughness))
    l.clearcoatRoughness *= sampleTexture(m, kTextureClearcoatRoughness, p).g;
  l.clearcoatNormal =
      mappedNormal(m, kTextureClearcoatNormal, m.layers.clearcoatNormalScale, p, vertexNormal(p));
}

void findSheen(inout SurfaceLayers l, Material m, SurfacePoint p) {
  l.sheenColor = m.layers.sheenColor;
  if (hasTexture(m, kTextureSheenColor)) l.sheenColor *= sampleTexture(m, kTextureSheenColor, p).rgb;
  l.sheenRoughness = m.layers.sheenRoughness;
  if (hasTexture(m, kTextureSheenRoughness)) l.sheenRoughness *= sampleTexture(m, kTextureSheenRoughness, p).a;
}

void findIridescence(inout SurfaceLayers l, Material m, SurfacePoint p) {
  l.iridescence = m.layers.iridescence;
  if (hasTexture(m, kTextureIridescence)) l.iridescence *= sampleTexture(m, kTextureIridescence, p).r;
  l.iridescenceIor = m.layers.iridescenceIor;
  l.iridescenceThickness = m.layers.iridescenceThickest;
  if (hasTexture(m, kTextureIridescenceThickness))
    l.iridescenceThickness = mix(m.layers.iridescenceThinnest, m.layers.iridescenceThickest,
                                 sampleTexture(m, kTextureIridescenceThickness, p).g);
}

// The length in world space of a meter along the normal in object space. It scales the thickness of a volume, such as a
// plate that the instance's transform stretches.
float stretchAlong(FrameConstants frame, SurfacePoint p) {
  return length(transpose(mat3(frameInstance(frame, p.instance).objectToWorld)) * vertexNormal(p));
}

void findTransmission(inout SurfaceLayers l, Material m, SurfacePoint p) {
  float root = sqrt(clamp(m.f0, 0.0, 0.99));  // of f0 = ((ior - 1) / (ior + 1))^2
  l.ior = (1.0 + root) / (1.0 - root);
  l.transmission = m.layers.transmission;
  if (hasTexture(m, kTextureTransmission)) l.transmission *= sampleTexture(m, kTextureTransmission, p).r;
}

void findVolume(inout SurfaceLayers l, FrameConstants frame, Material m, SurfacePoint p) {
  l.thickness = m.layers.thickness;
  if (hasTexture(m, kTextureThickness)) l.thickness *= sampleTexture(m, kTextureThickness, p).g;
  l.thickness *= stretchAlong(frame, p);
  l.absorption = absorptionOf(m.layers.attenuationColor, m.layers.attenuationDistance);
}

void findDiffuseTransmission(inout SurfaceLayers l, Material m, SurfacePoint p) {
  l.diffuseTransmission = m.layers.diffuseTransmission;
  if (hasTexture(m, kTextureDiffuseTransmission))
    l.diffuseTransmission *= sampleTexture(m, kTextureDiffuseTransmission, p).a;
  l.diffuseTransmissionColor = m.layers.diffuseTransmissionColor;
  if (hasTexture(m, kTextureDiffuseTransmissionColor))
    l.diffuseTransmissionColor *= sampleTexture(m, kTextureDiffuseTransmissionColor, p).rgb;
}

SurfaceLayers evaluateLayers(FrameConstants frame, Material m, SurfacePoint p, Surface s) {
  SurfaceLayers l = emptyLayers();
  if ((kLayers & kLayerClearcoat) != 0u) findClearcoat(l, m, p);
  if ((kLayers & kLayerSheen) != 0u) findSheen(l, m, p);
  if ((kLayers & kLayerAnisotropy) != 0u) findAnisotropy(l, m, p, s.normal);
  if ((kLayers & kLayerIridescence) != 0u) findIridescence(l, m, p);
  if ((kLayers & kLayerTransmission) != 0u) findTransmission(l, m, p);
  if ((kLayers & kLayerVolume) != 0u) findVolume(l, frame, m, p);
  if ((kLayers & kLayerDispersion) != 0u) l.dispersion = m.layers.dispersion;
  if ((kLayers & kLayerDiffuseTransmission) != 0u) findDiffuseTransmission(l, m, p);
  return l;
}
