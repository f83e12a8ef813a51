// The point of a surface that a fragment shows, and the draw's material: its textures are set 1, its record set 2
// (gpu_scene/materials.h). After varyings.glsl.
#include "render/glsl/material.glsl"
#include "render/glsl/multisample.glsl"

#ifdef TEXTURES_BY_INDEX
layout(set = 1, binding = 0) uniform sampler2D materialTextures[];
// All invocations of a draw have one material, so the index is uniform.
#define TEXTURE(m, slot) materialTextures[m.images[slot]]
#else
layout(set = 1, binding = 0) uniform sampler2D materialTexture0;
layout(set = 1, binding = 1) uniform sampler2D materialTexture1;
layout(set = 1, binding = 2) uniform sampler2D materialTexture2;
layout(set = 1, binding = 3) uniform sampler2D materialTexture3;
layout(set = 1, binding = 4) uniform sampler2D materialTexture4;
layout(set = 1, binding = 5) uniform sampler2D materialTexture5;
layout(set = 1, binding = 6) uniform sampler2D materialTexture6;
#ifdef COATED  // before the include: materials may have layers
layout(set = 1, binding = 7) uniform sampler2D materialTexture7;
layout(set = 1, binding = 8) uniform sampler2D materialTexture8;
layout(set = 1, binding = 9) uniform sampler2D materialTexture9;
layout(set = 1, binding = 10) uniform sampler2D materialTexture10;
layout(set = 1, binding = 11) uniform sampler2D materialTexture11;
layout(set = 1, binding = 12) uniform sampler2D materialTexture12;
layout(set = 1, binding = 13) uniform sampler2D materialTexture13;
layout(set = 1, binding = 14) uniform sampler2D materialTexture14;
layout(set = 1, binding = 15) uniform sampler2D materialTexture15;
layout(set = 1, binding = 16) uniform sampler2D materialTexture16;
layout(set = 1, binding = 17) uniform sampler2D materialTexture17;
layout(set = 1, binding = 18) uniform sampler2D materialTexture18;
#endif
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
// Levels follow from the gradients between pixels' centres: centroids lie anywhere in their pixels, and differences between
// them would blur one pixel and alias the next.
vec4 centreUv() { return interpolateAtOffset(varyingUv, vec2(0.0)); }
// Interpolated in the branch that samples, not once for all: lavapipe 22.3 finds other coordinates outside of it, farther
// from what one sample a pixel shows.
#define TEXEL(image, t)                                                                        \
  textureGrad(image, transformedUv(t, varyingUv), transformedGradient(t, dFdx(centreUv())), \
              transformedGradient(t, dFdy(centreUv())))
#else
// Levels follow from the quad: the hardware's own derivatives cost lavapipe a fourth less of the geometry pass than
// gradients that are handed to it.
#define TEXEL(image, t) texture(image, transformedUv(t, p.uv))
#endif

vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
  switch (slot) {
    case 0u: return TEXEL(TEXTURE(m, 0), m.transforms[0]);
    case 1u: return TEXEL(TEXTURE(m, 1), m.transforms[1]);
    case 2u: return TEXEL(TEXTURE(m, 2), m.transforms[2]);
    case 3u: return TEXEL(TEXTURE(m, 3), m.transforms[3]);
    case 4u: return TEXEL(TEXTURE(m, 4), m.transforms[4]);
    case 5u: return TEXEL(TEXTURE(m, 5), m.transforms[5]);
#ifdef COATED
    case 7u: return TEXEL(TEXTURE(m, 7), m.transforms[7]);
    case 8u: return TEXEL(TEXTURE(m, 8), m.transforms[8]);
    case 9u: return TEXEL(TEXTURE(m, 9), m.transforms[9]);
    case 10u: return TEXEL(TEXTURE(m, 10), m.transforms[10]);
    case 11u: return TEXEL(TEXTURE(m, 11), m.transforms[11]);
    case 12u: return TEXEL(TEXTURE(m, 12), m.transforms[12]);
    case 13u: return TEXEL(TEXTURE(m, 13), m.transforms[13]);
    case 14u: return TEXEL(TEXTURE(m, 14), m.transforms[14]);
    case 15u: return TEXEL(TEXTURE(m, 15), m.transforms[15]);
    case 16u: return TEXEL(TEXTURE(m, 16), m.transforms[16]);
    case 17u: return TEXEL(TEXTURE(m, 17), m.transforms[17]);
    case 18u: return TEXEL(TEXTURE(m, 18), m.transforms[18]);
#endif
    default: return TEXEL(TEXTURE(m, 6), m.transforms[6]);
  }
}

SurfacePoint fragmentPoint() {
  SurfacePoint p;
  p.position = varyingPosition;
  p.normal = varyingNormal;
  p.plane = cross(dFdy(varyingPosition), dFdx(varyingPosition));
  p.tangent = varyingTangent;
  p.uv = varyingUv;
  p.color = varyingColor;
  p.facing = gl_FrontFacing ? 1.0 : -1.0;
  p.instance = varyingInstance;
  p.triangle = uint(gl_PrimitiveID);
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
  if (cutOut(m, p)) discard;
#endif
}
