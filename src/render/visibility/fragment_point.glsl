// The point of a surface that a fragment shows, and the draw's material: its textures are set 1, its record set 2
// (gpu_scene/materials.h). After varyings.glsl.
#include "render/glsl/material.glsl"
#include "render/glsl/multisample.glsl"

// kTexture* of shared/types.h.
#define PLAIN_SLOTS(SLOT) SLOT(0) SLOT(1) SLOT(2) SLOT(3) SLOT(4) SLOT(5) SLOT(6)
#ifdef COATED  // before the include: materials may have layers
#define SLOTS(SLOT) \
  PLAIN_SLOTS(SLOT) SLOT(7) SLOT(8) SLOT(9) SLOT(10) SLOT(11) SLOT(12) SLOT(13) SLOT(14) SLOT(15) SLOT(16) SLOT(17) SLOT(18)
#else
#define SLOTS(SLOT) PLAIN_SLOTS(SLOT)
#endif

#ifdef TEXTURES_BY_INDEX
layout(set = 1, binding = 0) uniform sampler2D materialTextures[];
// All invocations of a draw have one material, so the index is uniform.
#define TEXTURE(m, slot) materialTextures[m.images[slot]]
#else
#define DECLARE(n) layout(set = 1, binding = n) uniform sampler2D materialTexture##n;
SLOTS(DECLARE)
#define TEXTURE(m, slot) materialTexture##slot
#endif
// The draw's material as a uniform buffer, not by address: texture coordinates depend on it, so helper invocations must
// see it too or derivatives break at triangle edges, and loads by address may give them nothing.
//
// An array of one, indexed by a 0 that no compiler knows (no address has its highest bit): lavapipe 22.3 otherwise
// compiles a variant of the shader for the material's values at every draw, 2.5 ms each, and never frees it. Only there:
// it costs an H200 a fifth of the geometry pass.
layout(set = 2, binding = 0, scalar) uniform MaterialUniform { Material materials[1]; };
Material drawMaterial() { return materials[kCpuDevice != 0u ? uint(push.frame >> 63) : 0u]; }

#ifdef MULTISAMPLED
// Where compute resolves it: in the middle of the samples that the triangle covers. At the pixel's centre, outside, a normal
// or a texture coordinate would be that of no point on the triangle, and a centroid may lie anywhere in the part that it
// covers.
#define INSIDE(v) interpolateAtOffset(v, middleOfSamples(uint(gl_SampleMaskIn[0])) - 0.5)
// Levels follow from the gradients between pixels' centres. Interpolated in the branch that samples, not once for all:
// lavapipe 22.3 finds other coordinates outside of it, farther from what one sample a pixel shows; and other gradients of
// the input itself.
#define CENTRE(v) interpolateAtOffset(v, vec2(0.0))
#define TEXEL(image, t)                                                                                        \
  textureGrad(image, transformedUv(t, INSIDE(varyingUv)), transformedGradient(t, dFdx(CENTRE(varyingUv))), \
              transformedGradient(t, dFdy(CENTRE(varyingUv))))
#else
#define INSIDE(v) v
#define CENTRE(v) v
// Levels follow from the quad: the hardware's own derivatives cost lavapipe a fourth less of the geometry pass than
// gradients that are handed to it.
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
  p.position = INSIDE(varyingPosition);
  p.normal = INSIDE(varyingNormal);
  p.plane = cross(dFdy(CENTRE(varyingPosition)), dFdx(CENTRE(varyingPosition)));
  p.tangent = INSIDE(varyingTangent);
  p.uv = INSIDE(varyingUv);
  p.color = INSIDE(varyingColor);
  p.facing = gl_FrontFacing ? 1.0 : -1.0;
  p.instance = varyingInstance;
  p.mesh = frameInstance(FrameRef(push.frame).v, varyingInstance).mesh;
  p.triangle = uint(gl_PrimitiveID) / (kVastDraw != 0u ? kVastFan : 1u);
  return p;
}

#ifdef MULTISAMPLED
// The samples that the mask leaves: an edge that it makes is one to smooth, too.
int uncutSamples(Material m) {
  int left = 0;
  for (int i = 0; i < int(kSamples); ++i) {
    precise float alpha = m.baseColor.a * interpolateAtSample(varyingColor, i).a;
    if (hasTexture(m, kTextureBaseColor))
      alpha *= texture(TEXTURE(m, 0), transformedUv(m.transforms[0], interpolateAtSample(varyingUv, i))).a;
    if (alpha >= m.alphaCutoff) left |= 1 << i;
  }
  return left;
}
#endif

// What a mask takes away of a fragment. Last in a shader, since textures need the whole quad.
void cutFragment(Material m, SurfacePoint p) {
#ifdef MULTISAMPLED
  gl_SampleMask[0] &= uncutSamples(m);
  if (gl_SampleMask[0] == 0) discard;
#else
  if (masked(m, p)) discard;
#endif
}
