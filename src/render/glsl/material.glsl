// Evaluation of materials at a SurfacePoint, independent of the shader stage. The raster defines sampleTexture(),
// because it determines the texture gradients.
#ifndef LATELIGHT_MATERIAL_GLSL
#define LATELIGHT_MATERIAL_GLSL

struct SurfacePoint {
  vec3 position;  // world space
  vec3 normal;    // world space, interpolated, any length; 0 if opposite normals cancel
  vec3 plane;     // world space, any length: normal of the surface's plane, towards the viewer
  vec4 tangent;   // world space, interpolated, any length; w: sign of the bitangent, 0: no tangent frame
  vec4 uv;        // UV sets 0 and 1
  vec4 color;     // vertex color
  float facing;   // 1 on a front face, -1 on a back face
  uint instance;
  uint mesh;
  uint triangle;  // index in the mesh
};

// The texture slots kTexture* of shared/types.h that evaluateMaterial() reads.
#define PLAIN_SLOTS(SLOT) SLOT(0) SLOT(1) SLOT(2) SLOT(3) SLOT(4) SLOT(5) SLOT(6)

// Returns the texel of a material's texture at the point. The call is uniform for all invocations with the same
// material.
vec4 sampleTexture(Material m, uint slot, SurfacePoint p);

// FrameConfig::textureSlots: code for slots that no material of the scene uses is not compiled.
layout(constant_id = kTextureSlotsConstant) const uint kTextureSlots = ~0u;
// FrameConfig::traits: kTrait* that all materials or meshes share. Code for others is not compiled.
layout(constant_id = kTraitsConstant) const uint kTraits = 0u;
bool allHave(uint trait) { return (kTraits & trait) != 0u; }
bool hasExtras(Instance instance) { return !allHave(kTraitNoExtras) && (instance.flags & kInstanceExtras) != 0u; }

bool hasTexture(Material m, uint slot) { return (m.textures & kTextureSlots & (1u << slot)) != 0u; }

// Precise, so that the alpha test has the same result in all passes.
vec2 transformedUv(TextureTransform t, vec4 uvSets) {
  if (allHave(kTraitPlainUv)) return uvSets.xy;
  vec3 uv = vec3(t.uvSet == 0u ? uvSets.xy : uvSets.zw, 1.0);
  precise vec2 transformed = vec2(dot(t.row0, uv), dot(t.row1, uv));
  return transformed;
}

// Transforms a gradient of both UV sets.
vec2 transformedGradient(TextureTransform t, vec4 uvSets) {
  if (allHave(kTraitPlainUv)) return uvSets.xy;
  vec2 uv = t.uvSet == 0u ? uvSets.xy : uvSets.zw;
  return vec2(dot(t.row0.xy, uv), dot(t.row1.xy, uv));
}

// Texture fetches may stand in a branch, because the condition depends only on the material, which is uniform.
vec4 baseColor(Material m, SurfacePoint p) {
  vec4 c = m.baseColor * p.color;
  if (hasTexture(m, kTextureBaseColor)) c *= sampleTexture(m, kTextureBaseColor, p);
  return c;
}

// Alpha test: returns true if the point is removed (glTF 2.0, section 3.9.4). For a blended material that is drawn as
// opaque for data outputs, returns true if it is fully transparent.
bool masked(Material m, SurfacePoint p) {
  precise float alpha = baseColor(m, p).a;
  if ((m.flags & kMaterialMasked) != 0u) return alpha < m.alphaCutoff;
  return (m.flags & kMaterialBlended) != 0u && alpha <= 0.0;
}

#endif
