#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, multisampled, textured
// The geometry pass of deferred shading: writes the visible surfaces to the G-buffer of a layout (hardware raster).
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#include "render/glsl/gbuffer_write.glsl"
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

void main() {
#ifdef MULTISAMPLED
  gl_SampleMask[0] = -1;
#endif
  FrameConstants frame = FrameRef(push.frame).v;
  Material m = drawMaterial();
  SurfacePoint p = fragmentPoint();
  Surface s = evaluateMaterial(frame, m, p);
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
