#version 460
#extension GL_GOOGLE_include_directive : require
// The lit picture: emitted radiance, environment, and the lights that the volumes added up.
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/environment.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = AFTER_LIT_MAPS) uniform sampler2DArray lightSum;

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
  Surface s = readSurface(view, pixel, depth, accumulated.a);
  if ((s.flags & kSurfaceUnlit) != 0u) s = withoutReflection(s);
  vec3 radiance = environmentLight(frame, s, directionToEye(view, s.position)) + texelFetch(lightSum, pixel, 0).rgb;
  imageStore(lightTarget, pixel, vec4(min(accumulated.rgb + radiance * frame.exposure, vec3(65504.0)), 1.0));
}
