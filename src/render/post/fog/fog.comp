#version 460
#extension GL_GOOGLE_include_directive : require
// Fog: attenuates the lit picture by the fog between the eye and the surface at each pixel's depth. Pixels without a
// surface are covered by fog up to infinity. Input: gbufferDepth. Input and output: lightTarget.
#include "render/glsl/common.glsl"
#include "render/glsl/fog.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/post/fog/fog_push.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray gbufferDepth;
layout(set = 0, binding = 1, rgba16f) uniform image2DArray lightTarget;

layout(push_constant, scalar) uniform Push { FogPush push; };

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(frame, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  vec2 ndc = pixelToNdc(vec2(pixel.xy) + 0.5, view.size);
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  vec3 ray = pixelRay(frame, view, vec2(pixel.xy) + 0.5);
  if (ray == vec3(0.0)) return;
  float away = viewDepth(view.projection, depth);
  vec3 seen = kLens != 0u ? ray * away : viewPositionAtDepth(view.projection, ndc, away);
  float transmittance = depth == 0.0 ? fogTransmittanceBeyond(frame.fog, view, ndc, ray)
                                     : fogTransmittanceTo(frame.fog, view, seen);
  imageStore(lightTarget, pixel, applyFog(frame.fog, imageLoad(lightTarget, pixel), transmittance));
}
