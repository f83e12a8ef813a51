#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, textured
// Multi-pass forward shading, first pass: outputs emission, the light of the environment and of area lights, and the
// surface's identity, against which forward_light.frag compares its fragments.
#include "render/glsl/common.glsl"
#include "render/glsl/multisample.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#include "shared/gbuffer.h"
#include "render/glsl/environment.glsl"
#include "render/glsl/area_lights.glsl"

layout(constant_id = kAlphaMaskedConstant) const uint kAlphaMasked = 0;

layout(location = 0) out vec4 radiance;
layout(location = 1) out uvec2 surface;  // instance and triangle
layout(location = 2) out vec4 counts;

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
  vec3 reflected = environmentLight(frame, s, toEye);
  if (kAreaLights != kAreaLightsNone) {
    prepareForLights(s, toEye);
    reflected += areaLight(frame, s, toEye);
  }
  radiance = vec4(min(emitted * frame.exposure, vec3(65504.0)) + reflected * frame.exposure, 1.0);
  surface = uvec2(varyingInstance, push.firstTriangle + uint(gl_PrimitiveID));
  counts = vec4(0.0);
  // As in geometry.frag, the discard comes last, because texture derivatives need the full quad.
  if (kAlphaMasked != 0u) alphaTest(m, p);
}
