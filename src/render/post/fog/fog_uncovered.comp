#version 460
#extension GL_GOOGLE_include_directive : require
// Fog in pictures with several samples per pixel: covers the share of each pixel that no surface covers by fog up to
// infinity. The lighting shaders apply the fog before surfaces (surface_fog.glsl). Input and output: lightTarget,
// premultiplied, before the background.
#include "render/glsl/common.glsl"
#include "render/glsl/fog.glsl"
#include "render/post/fog/fog_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0, rgba16f) uniform image2DArray lightTarget;

layout(push_constant, scalar) uniform Push { FogPush push; };

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(frame, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  vec4 drawn = imageLoad(lightTarget, pixel);
  if (drawn.a == 1.0) return;
  vec2 ndc = pixelToNdc(vec2(pixel.xy) + 0.5, view.size);
  float transmittance = fogTransmittanceBeyond(frame.fog, view, ndc, viewRay(view.projection, ndc));
  imageStore(lightTarget, pixel, drawn + applyFog(frame.fog, vec4(0.0), transmittance) * (1.0 - drawn.a));
}
