// Materials at a point of a surface. What finds the point, and so how texture levels follow from its neighbours, is the
// rasterizer's: it defines sampleTexture(). Nothing here is a shader stage's own.
#ifndef LATELIGHT_MATERIAL_GLSL
#define LATELIGHT_MATERIAL_GLSL

struct SurfacePoint {
  vec3 position;  // world
  vec3 normal;    // world, interpolated, any length; 0 where opposite normals cancel
  vec3 plane;     // world, towards the viewer, any length: of the plane that the surface has around the point
  vec4 tangent;   // world, interpolated, any length; w: sign of the bitangent, 0 without a tangent frame
  vec4 uv;        // UV sets 0 and 1
  vec4 color;     // vertex colour
  float facing;   // 1 on a front face, -1 on a back face
  uint instance;
  uint mesh;
  uint triangle;  // of the mesh
};

// The texel of a material's texture at the point: the same for all invocations where the material is.
vec4 sampleTexture(Material m, uint slot, SurfacePoint p);

// FrameConfig::textureSlots: what no material of the scene has a texture in need not be compiled.
layout(constant_id = 8) const uint kTextureSlots = ~0u;
bool hasTexture(Material m, uint slot) { return (m.textures & kTextureSlots & (1u << slot)) != 0u; }

// Precise, so that a mask cuts the same wherever it is looked up.
vec2 transformedUv(TextureTransform t, vec4 uvSets) {
  vec3 uv = vec3(t.uvSet == 0u ? uvSets.xy : uvSets.zw, 1.0);
  precise vec2 transformed = vec2(dot(t.row0, uv), dot(t.row1, uv));
  return transformed;
}

// Of a direction in both UV sets, as a gradient is one.
vec2 transformedGradient(TextureTransform t, vec4 uvSets) {
  vec2 uv = t.uvSet == 0u ? uvSets.xy : uvSets.zw;
  return vec2(dot(t.row0.xy, uv), dot(t.row1.xy, uv));
}

// A texture fetch may stand in a branch: the condition is the material's, the same for all invocations.
vec4 baseColor(Material m, SurfacePoint p) {
  vec4 c = m.baseColor * p.color;
  if (hasTexture(m, kTextureBaseColor)) c *= sampleTexture(m, kTextureBaseColor, p);
  return c;
}

// Whether the alpha mask takes this point away (glTF 2.0, section 3.9.4). Of a blended material, drawn as if it were
// solid for data outputs: whether it shows at all.
bool masked(Material m, SurfacePoint p) {
  precise float alpha = baseColor(m, p).a;
  if ((m.flags & kMaterialMasked) != 0u) return alpha < m.alphaCutoff;
  return (m.flags & kMaterialBlended) != 0u && alpha <= 0.0;
}

#endif
