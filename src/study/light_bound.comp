#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// The lower bound of lighting, without light culling or light loads: each pixel generates its own lights, a meter above
// its surface, and shades them as every technique does.
#include "render/glsl/common.glsl"
#define ONE_SAMPLE
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/one_light.glsl"
#include "study/light_bound_push.h"

layout(constant_id = kLightTypeConstant) const uint kLightType = 0;  // kLight*
layout(push_constant, scalar) uniform Push { LightBoundPush push; };

// Each light has its own position, so that no intermediate result can be shared between lights.
Light madeUp(Surface s, uint index) {
  Light light = push.light;
  vec3 apart = push.apart * float(index);
  light.type = kLightType;
  light.position = s.position + s.normal + apart;
  light.direction = apart - s.normal;
  return light;
}

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) {
  SurfaceBrdf brdf = surfaceBrdf(p.s, p.toEye, kShading);
  vec3 radiance = vec3(0.0);
  for (uint i = 0u; i < push.lights; ++i) {
    radiance += shadeUnshadowed(sampleLight(madeUp(p.s, i), p.s.position), brdf);
    lightsTested += 1.0;
  }
  return radiance;
}

void main() {
  bindSurfaces(push.frame, push.shown);
  ivec3 place = ownPixel();
  bool lit = lightPixel(frameOf(push.frame, gl_WorkGroupID.z), place);
  writeCounts(place, lit, lightCount());
}
