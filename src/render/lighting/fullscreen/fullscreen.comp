#version 460
#extension GL_GOOGLE_include_directive : require
// fullscreen: one pass over the picture, every light at every pixel (rows 3 and 16 of the design).
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#define ENVIRONMENT_BINDING (2 GBUFFER_TARGETS(COUNT))
#include "render/glsl/environment.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(constant_id = 0) const uint kNormalEncoding = 0;
layout(constant_id = 1) const uint kShading = 0;

struct LightingPush {
  uint64_t frame;  // FrameConstants
};
layout(push_constant, scalar) uniform Push { LightingPush push; };

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(frame, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  if (depth == 0.0) {
    imageStore(lightTarget, pixel, vec4(0.0));
    return;
  }
  vec4 accumulated = imageLoad(lightTarget, pixel);
  Surface s = readSurface(view, pixel, depth, accumulated.a, kNormalEncoding);
  if ((s.flags & kSurfaceUnlit) != 0u) s = withoutReflection(s);
  vec3 toEye = view.projection.kind == kPerspective ? normalize(view.eye - s.position)
                                                    : -rotateToWorld(view, vec3(0.0, 1.0, 0.0));

  vec3 radiance = environmentLight(frame, s, toEye);
  for (uint i = 0u; i < frame.lightCount; ++i) {
    Light light = frameLight(frame, i);
    vec3 offset = light.position - s.position;
    if (light.type != kLightDirectional && dot(offset, offset) >= light.reach * light.reach) continue;
    radiance += shadeLight(s, toEye, sampleLight(light, s.position), kShading);
  }
  imageStore(lightTarget, pixel, vec4(min(accumulated.rgb + radiance * frame.exposure, vec3(65504.0)), 1.0));
}
