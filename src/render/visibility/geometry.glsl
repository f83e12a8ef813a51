// The geometry pass of deferred shading: writes the visible surfaces to the G-buffer of a layout (hardware raster).
// With DATA_WORDS it also writes what data outputs are packed from (outputs/pack_surfaces.comp). Include last.
#ifdef GBUFFER_KEEPS_MOTION
#include "render/visibility/motion_varyings.glsl"
#endif

layout(constant_id = kAlphaMaskedConstant) const uint kAlphaMasked = 0;
// Bit i: target i is written; the bit after the last target: light. If a target is not written, the constant removes
// its code, which lavapipe would otherwise execute.
layout(constant_id = kDrawnTargetsConstant) const uint kTargets = ~0u;

#define OUTPUT(index, name, format, type, channels) layout(location = index) out type gbuffer_##name;
GBUFFER_TARGETS(OUTPUT)
#define COUNT(index, name, format, type, channels) +1
layout(location = 0 GBUFFER_TARGETS(COUNT)) out vec4 lightAccumulation;

#ifdef DATA_WORDS
// The remaining color attachments, of eight, each with four words of the layout `exact` (outputs/data_words.glsl).
#define LESS(index, name, format, type, channels) -1
#define DATA_IMAGES (7 GBUFFER_TARGETS(LESS))
#define DATA(i) layout(location = 1 + i GBUFFER_TARGETS(COUNT)) out uvec4 dataWords##i;
#define WRITE_DATA(i) dataWords##i = exactWords(targets, kDataWords##i);
#if DATA_IMAGES >= 1
DATA(0)
#endif
#if DATA_IMAGES >= 2
DATA(1)
#endif
#if DATA_IMAGES >= 3
DATA(2)
#endif
#if DATA_IMAGES >= 4
DATA(3)
#endif
#if DATA_IMAGES >= 5
DATA(4)
#endif
#if DATA_IMAGES >= 6
DATA(5)
#endif

void writeDataWords(ExactTargets targets) {
#if DATA_IMAGES >= 1
  WRITE_DATA(0)
#endif
#if DATA_IMAGES >= 2
  WRITE_DATA(1)
#endif
#if DATA_IMAGES >= 3
  WRITE_DATA(2)
#endif
#if DATA_IMAGES >= 4
  WRITE_DATA(3)
#endif
#if DATA_IMAGES >= 5
  WRITE_DATA(4)
#endif
#if DATA_IMAGES >= 6
  WRITE_DATA(5)
#endif
}
#endif

void main() {
#ifdef MULTISAMPLED
  gl_SampleMask[0] = -1;
#endif
  FrameConstants frame = FrameRef(push.frame).v;
  frame.exposure = uintBitsToFloat(varyingNumbers.w);
  Material m = drawMaterial();
  SurfacePoint p = fragmentPoint();
  Surface s = evaluateMaterial(frame, m, p);
#ifdef DATA_WORDS
  writeDataWords(exactTargets(s));
#endif
  bool wantsLight = (kTargets >> (0 GBUFFER_TARGETS(COUNT)) & 1u) != 0u;
  lightAccumulation = wantsLight ? emittedLight(frame, s) : vec4(0.0);
  s = storedSurface(s);
  GbufferContext context = gbufferContext(frameView(frame, push.view), gl_FragCoord.xy);
#ifdef GBUFFER_KEEPS_MOTION
  s.motion = surfaceMotion(context.view.size).xy;
#endif
  GbufferTexel texel = packGbuffer(s, context);
#define WRITE(index, name, format, type, channels) \
  gbuffer_##name = (kTargets >> index & 1u) != 0u ? texel.name : type(0);
  GBUFFER_TARGETS(WRITE)
  // The depth pass rejects masked fragments, but another surface may have exactly the same depth. This test comes last,
  // because textures need the whole quad.
  if (kAlphaMasked != 0u) alphaTest(m, p);
}
