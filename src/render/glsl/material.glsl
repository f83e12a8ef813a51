// The draw's material in fragment shaders: its textures are set 1. After varyings.glsl.
#include "render/glsl/multisample.glsl"
layout(set = 1, binding = 0) uniform sampler2D materialTextures0;
layout(set = 1, binding = 1) uniform sampler2D materialTextures1;
layout(set = 1, binding = 2) uniform sampler2D materialTextures2;
layout(set = 1, binding = 3) uniform sampler2D materialTextures3;
layout(set = 1, binding = 4) uniform sampler2D materialTextures4;
layout(set = 1, binding = 5) uniform sampler2D materialTextures5;
layout(set = 1, binding = 6) uniform sampler2D materialTextures6;
// The draw's material as a uniform buffer, not by address: texture coordinates depend on it, so helper invocations must
// see it too or derivatives break at triangle edges, and loads by address may give them nothing.
//
// An array of one, indexed by a 0 that no compiler knows (no address has its highest bit): lavapipe 22.3 otherwise
// compiles a variant of the shader for the material's values at every draw, 2.5 ms each, and never frees it. Only there:
// it costs an H200 a fifth of the geometry pass.
layout(constant_id = 100) const uint kCpuDevice = 0;
layout(set = 1, binding = 7, scalar) uniform MaterialUniform { Material materials[1]; };
Material drawMaterial() { return materials[kCpuDevice != 0u ? uint(push.frame >> 63) : 0u]; }

// Precise, so that a mask cuts the same in the depth pass and in the geometry pass.
vec2 transformedUv(TextureTransform t, vec4 uvSets) {
  vec3 uv = vec3(t.uvSet == 0u ? uvSets.xy : uvSets.zw, 1.0);
  precise vec2 transformed = vec2(dot(t.row0, uv), dot(t.row1, uv));
  return transformed;
}

vec2 textureUv(TextureTransform t) { return transformedUv(t, varyingUv); }

// FrameSetup::textureSlots: what no material of the scene has a texture in need not be compiled.
layout(constant_id = 8) const uint kTextureSlots = ~0u;
bool hasTexture(Material m, uint slot) { return (m.textures & kTextureSlots & (1u << slot)) != 0u; }

#ifdef MULTISAMPLED
// Levels follow from the gradients between pixels' centres: centroids lie anywhere in their pixels, and differences between
// them would blur one pixel and alias the next.
vec4 centreUv() { return interpolateAtOffset(varyingUv, vec2(0.0)); }
vec2 textureGradient(TextureTransform t, vec4 uvSets) {
  vec2 uv = t.uvSet == 0u ? uvSets.xy : uvSets.zw;
  return vec2(dot(t.row0.xy, uv), dot(t.row1.xy, uv));
}
#define SAMPLE(image, t) \
  textureGrad(image, textureUv(t), textureGradient(t, dFdx(centreUv())), textureGradient(t, dFdy(centreUv())))
#else
#define SAMPLE(image, t) texture(image, textureUv(t))
#endif

// A texture fetch may stand in a branch: the condition is the material's, the same for the whole draw.
#define FETCH(m, slot) SAMPLE(materialTextures##slot, m.transforms[slot])

vec4 baseColor(Material m) {
  vec4 c = m.baseColor * varyingColor;
  if (hasTexture(m, kTextureBaseColor)) c *= FETCH(m, 0);
  return c;
}

// Whether the alpha mask takes this fragment away (glTF 2.0, section 3.9.4). Of a blended material, drawn as if it were
// solid for data outputs: whether it shows at all.
bool cutOut(Material m) {
  precise float alpha = baseColor(m).a;
  return (m.flags & kMaterialBlended) != 0u ? alpha <= 0.0 : alpha < m.alphaCutoff;
}

#ifdef MULTISAMPLED
// The samples that the mask leaves: an edge that it makes is one to smooth, too.
int uncutSamples(Material m) {
  int left = 0;
  for (int i = 0; i < int(kSamples); ++i) {
    precise float alpha = m.baseColor.a * interpolateAtSample(varyingColor, i).a;
    if (hasTexture(m, kTextureBaseColor))
      alpha *= texture(materialTextures0, transformedUv(m.transforms[0], interpolateAtSample(varyingUv, i))).a;
    if (alpha >= m.alphaCutoff) left |= 1 << i;
  }
  return left;
}
#endif

// What a mask takes away of a fragment. Last in a shader, since textures need the whole quad.
void cutFragment(Material m) {
#ifdef MULTISAMPLED
  gl_SampleMask[0] &= uncutSamples(m);
  if (gl_SampleMask[0] == 0) discard;
#else
  if (cutOut(m)) discard;
#endif
}
