#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, textured
// Forward shading of a visible surface with a layered material. Outputs its radiance, and the numbers of lights tested
// and used.
#define COATED
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#define PARTIAL_SUBGROUPS
#include "render/layered/layered_light.glsl"
#include "render/glsl/surface_fog.glsl"

layout(constant_id = kAlphaMaskedConstant) const uint kAlphaMasked = 0;
layout(constant_id = kPlainLoopConstant) const uint kPlainLoop = 0;

layout(location = 0) out vec4 picture;
layout(location = 1) out vec4 counts;

void main() {
#ifdef MULTISAMPLED
  gl_SampleMask[0] = -1;
#endif
  FrameConstants frame = FrameRef(push.frame).v;
  Material m = drawMaterial();
  SurfacePoint p = fragmentPoint();
  LayeredPoint point = layeredPoint(frame, push.view, m, p);
  point.s.ao *= visibleHemisphere(ivec3(ivec2(gl_FragCoord.xy), int(push.view)));
  LayeredBrdf brdf = layeredBrdfAt(point);
  vec3 radiance = layeredEnvironment(frame, brdf, point.toEye);
  radiance += layeredAreaLight(frame, brdf);
  radiance += lightsAtPoint(frame, push.view, point, brdf, true, kPlainLoop != 0u);
  picture = vec4(exposedRadiance(frame, point, brdf, radiance), 1.0);
#ifdef MULTISAMPLED
  picture.rgb *= transmittanceFrom(frame, frameView(frame, push.view), point.s.position);
#endif
  counts = lightCount();
  // As in geometry.frag, the discard comes last, because texture derivatives need the full quad.
  if (kAlphaMasked != 0u) alphaTest(m, p);
}
