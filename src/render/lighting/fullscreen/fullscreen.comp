#version 460
#extension GL_GOOGLE_include_directive : require
// fullscreen: one pass over the picture, every light at every pixel (rows 3 and 16 of the design).
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#define ENVIRONMENT_BINDING GBUFFER_BINDINGS
#include "render/glsl/environment.glsl"
#include "render/glsl/lights.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

struct LightingPush {
  uint64_t frame;  // FrameConstants
};
layout(push_constant, scalar) uniform Push { LightingPush push; };

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(frame, pixel.z);
  bool inside = all(lessThan(vec2(pixel.xy), view.size));
  float depth = inside ? texelFetch(gbufferDepth, pixel, 0).r : 0.0;
  bool lit = depth != 0.0;
  vec4 accumulated = vec4(0.0);
  Surface s = emptySurface();
  vec3 toEye = vec3(0.0, 0.0, 1.0);
  vec3 radiance = vec3(0.0);
  if (lit) {
    accumulated = imageLoad(lightTarget, pixel);
    s = readSurface(view, pixel, depth, accumulated.a);
    if ((s.flags & kSurfaceUnlit) != 0u) s = withoutReflection(s);
    toEye = directionToEye(view, s.position);
    radiance = environmentLight(frame, s, toEye);
  }
  radiance += shadeAllLights(frame, s, toEye, lit);
  vec4 result = vec4(min(accumulated.rgb + radiance * frame.exposure, vec3(65504.0)), 1.0);
  if (inside) imageStore(lightTarget, pixel, lit ? result : vec4(0.0));
  if (kCountLights != 0u && inside) imageStore(lightCounts, pixel, lit ? lightCount() : vec4(0.0));
}
