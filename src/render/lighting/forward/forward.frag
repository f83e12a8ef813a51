#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, textured
// Forward shading in a single pass: evaluates the material of a visible surface, the environment and all lights, and
// outputs the lit picture and the numbers of lights tested and used.
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#include "shared/gbuffer.h"
#include "render/glsl/environment.glsl"
#include "render/glsl/area_lights.glsl"
#include "render/glsl/lights.glsl"

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
  Surface s = evaluateMaterial(frame, m, p);
  s.ao *= visibleHemisphere(ivec3(ivec2(gl_FragCoord.xy), int(push.view)));
  vec3 emitted = emittedRadiance(s);
  s = litSurface(s);
  vec3 toEye = directionToEye(frameView(frame, push.view), s.position);
  vec3 radiance = environmentLight(frame, s, toEye);
  prepareForLights(s, toEye);
  radiance += areaLight(frame, s, toEye);
  SurfaceBrdf brdf = surfaceBrdf(s, toEye, kShading);
  radiance += kPlainLoop != 0u ? shadeAllLightsPlainly(frame, push.view, s, brdf)
                               : shadeAllLights(frame, push.view, s, brdf, true);
  // Emitted radiance is clamped separately, as in the light accumulation target of the deferred techniques.
  vec3 sum = min(emitted * frame.exposure, vec3(65504.0)) + radiance * frame.exposure;
  picture = vec4(min(sum, vec3(65504.0)), 1.0);
  counts = lightCount();
  // The depth pass discarded masked-out fragments, but another surface may lie at exactly the same depth. The discard
  // comes last, because texture derivatives need the full quad.
  if (kAlphaMasked != 0u) alphaTest(m, p);
}
