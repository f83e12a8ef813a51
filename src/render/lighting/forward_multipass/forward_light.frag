#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, textured
// Multi-pass forward shading, the pass of one light: evaluates the complete material again and outputs the radiance
// that the light adds, for additive blending.
#include "render/glsl/common.glsl"
#define DRAW_PUSH LightDraw
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#include "render/glsl/multisample.glsl"
#include "render/glsl/environment.glsl"
#include "render/glsl/one_light.glsl"
#include "shared/gbuffer.h"

layout(constant_id = kAlphaMaskedConstant) const uint kAlphaMasked = 0;
layout(set = 0, binding = AFTER_LIT_MAPS) uniform TARGET_USAMPLER surfaces;  // written by forward_base.frag

layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 counts;

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  Material m = drawMaterial();
  SurfacePoint p = fragmentPoint();
  Surface s = evaluateMaterial(frame, m, p);
  vec3 toEye = directionToEye(frameView(frame, push.view), s.position);
  prepareForLights(s, toEye);
  vec3 one = shadeOneLight(frame, more.light, more.shadow, s, surfaceBrdf(s, toEye, kShading));
  lightsTested = 1.0;
  // All surfaces at the same depth pass the test, but light may be added only to the visible one.
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
  uint showing = 0u;  // mask of the samples at which this surface is visible
  for (int i = 0; i < int(kSamples); ++i)
    if (texelFetch(surfaces, pixel, i).rg == uvec2(varyingInstance, gl_PrimitiveID)) showing |= 1u << i;
  bool shows = showing != 0u;
#ifdef MULTISAMPLED
  gl_SampleMask[0] = int(showing);
#endif
  radiance = shows ? vec4(one * frame.exposure, 0.0) : vec4(0.0);
  counts = shows ? lightCount() : vec4(0.0);
  if (kAlphaMasked != 0u) alphaTest(m, p);
}
