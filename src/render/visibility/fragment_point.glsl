// The SurfacePoint of a fragment, and the draw's material: its textures are set 1, its record is set 2
// (gpu_scene/materials.h). Include after varyings.glsl.
#include "render/glsl/material.glsl"
#include "render/glsl/multisample.glsl"

#ifdef COATED  // define before the include: materials may have coats
#define SLOTS(SLOT) \
  PLAIN_SLOTS(SLOT) SLOT(7) SLOT(8) SLOT(9) SLOT(10) SLOT(11) SLOT(12) SLOT(13) SLOT(14) SLOT(15) SLOT(16) SLOT(17) SLOT(18)
#else
#define SLOTS(SLOT) PLAIN_SLOTS(SLOT)
#endif

#ifdef TEXTURES_BY_INDEX
layout(set = 1, binding = 0) uniform sampler2D materialTextures[];
// Bindless textures. All invocations of a draw have one material, so the index is uniform.
#define TEXTURE(m, slot) materialTextures[m.images[slot]]
#else
#define DECLARE(n) layout(set = 1, binding = n) uniform sampler2D materialTexture##n;
SLOTS(DECLARE)
#define TEXTURE(m, slot) materialTexture##slot
#endif
// The draw's material is a uniform buffer, not a buffer reference. Texture coordinates depend on it, so helper
// invocations must read it too, or derivatives are wrong at triangle edges; loads by address may return nothing in
// helper invocations.
//
// It is an array of one element, indexed by a 0 that no compiler can fold (no address has its highest bit set).
// Otherwise lavapipe compiles a shader variant for the material's values at every draw and never frees it. Other
// devices use a constant index, because the dynamic one slows down the geometry pass.
//
// On lavapipe the dynamic index makes each word a gather of all lanes. Members that decide no branch are therefore read
// with a constant index there as well: a variant depends only on values in conditions.
layout(set = 2, binding = 0, scalar) uniform MaterialUniform { Material materials[1]; };
Material drawMaterial() {
  if (kCpuDevice == 0u) return materials[0];
  uint index = uint(push.frame >> 63);
  Material m = materials[index];
#ifndef COATED
  m.baseColor = materials[0].baseColor;
  m.emissive = materials[0].emissive;
  m.normalScale = materials[0].normalScale;
  m.occlusionStrength = materials[0].occlusionStrength;
  m.id = materials[0].id;
#define CONSTANT_TRANSFORM(n)                                \
  m.transforms[n].row0 = materials[0].transforms[n].row0; \
  m.transforms[n].row1 = materials[0].transforms[n].row1;
  PLAIN_SLOTS(CONSTANT_TRANSFORM)
#endif
  return m;
}

#ifdef MULTISAMPLED
// Attributes are evaluated at the center of the covered samples, as in the compute resolve. The pixel's center may lie
// outside the triangle, where a normal or texture coordinate belongs to no point of it, and a centroid may lie anywhere
// in the covered part.
#define AT_CENTROID(v) interpolateAtOffset(v, sampleCentroid(uint(gl_SampleMaskIn[0])) - 0.5)
// lavapipe (of Mesa 22.3) divides what it interpolates elsewhere by the reciprocal depth at the pixel's center, so all
// values are wrong by the same factor, which a value of 1 shows.
float unscaled(float one) { return kCpuDevice != 0u ? 1.0 / one : 1.0; }
#define INSIDE(v) (AT_CENTROID(v) * unscaled(AT_CENTROID(varyingPosition).w))
// Mip levels follow from the gradients between pixel centers. The interpolation stands in the branch that samples:
// outside of it, lavapipe returns other coordinates, which differ more from those of single-sampled rendering, and
// other gradients of the input itself.
#define CENTRE(v) interpolateAtOffset(v, vec2(0.0))
#define TEXEL(image, t)                                                                                        \
  textureGrad(image, transformedUv(t, INSIDE(varyingUv)), transformedGradient(t, dFdx(CENTRE(varyingUv))), \
              transformedGradient(t, dFdy(CENTRE(varyingUv))))
#else
#define INSIDE(v) v
#define CENTRE(v) v
// Mip levels follow from the quad's implicit derivatives, which are faster on lavapipe than explicit gradients.
#define TEXEL(image, t) texture(image, transformedUv(t, p.uv))
#endif

vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
#define SAMPLE(n) case uint(n): return TEXEL(TEXTURE(m, n), m.transforms[n]);
  switch (slot) {
    SLOTS(SAMPLE)
    default: return vec4(0.0);
  }
}

SurfacePoint fragmentPoint() {
  SurfacePoint p;
  p.position = INSIDE(varyingPosition).xyz;
  p.normal = INSIDE(varyingNormal);
  p.plane = cross(dFdy(CENTRE(varyingPosition)).xyz, dFdx(CENTRE(varyingPosition)).xyz);
  p.tangent = INSIDE(varyingTangent);
  p.uv = INSIDE(varyingUv);
  p.color = INSIDE(varyingColor);
  p.facing = gl_FrontFacing ? 1.0 : -1.0;
  p.instance = varyingInstance;
#ifdef DRAW_NUMBERS
  p.mesh = varyingNumbers.z;
#else
  p.mesh = frameInstance(FrameRef(push.frame).v, varyingInstance).mesh;
#endif
  p.triangle = (push.firstTriangle + uint(gl_PrimitiveID)) / (kVastDraw != 0u ? kVastFan : 1u);
  return p;
}

#ifdef MULTISAMPLED
// Returns the samples that pass the alpha test. The test runs per sample, so that masked edges are anti-aliased too.
int alphaTestedSamples(Material m) {
  int left = 0;
  for (int i = 0; i < int(kSamples); ++i) {
    float scale = unscaled(interpolateAtSample(varyingPosition, i).w);
    precise float alpha = m.baseColor.a * (interpolateAtSample(varyingColor, i).a * scale);
    if (hasTexture(m, kTextureBaseColor))
      alpha *= texture(TEXTURE(m, 0), transformedUv(m.transforms[0], interpolateAtSample(varyingUv, i) * scale)).a;
    if (alpha >= m.alphaCutoff) left |= 1 << i;
  }
  return left;
}
#endif

// Alpha test. Call it last in a shader, because textures need the whole quad.
void alphaTest(Material m, SurfacePoint p) {
#ifdef MULTISAMPLED
  gl_SampleMask[0] &= alphaTestedSamples(m);
  if (gl_SampleMask[0] == 0) discard;
#else
  if (masked(m, p)) discard;
#endif
}
