#version 460
#extension GL_GOOGLE_include_directive : require
// One light at the pixels its volume covers, added to the others.
#include "render/glsl/common.glsl"
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/one_light.glsl"
#include "render/lighting/volumes/volume_push.glsl"

// Not by address, whose loads cost lavapipe more than the light.
layout(set = 0, binding = AFTER_LIT_MAPS, scalar) uniform ViewUniform { View view; };

layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 counts;

void main() {
  ivec3 pixel = ivec3(ivec2(gl_FragCoord.xy), int(push.view));
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  Surface s = readSurface(view, pixel, depth, 1.0);  // occlusion is the environment's alone
  if ((s.flags & kSurfaceUnlit) != 0u) s = withoutReflection(s);
  vec3 one = shadeOneLight(push.light, s, directionToEye(view, s.position));
  lightsTested = 1.0;
  // Volumes that reach the far plane cover background too.
  radiance = depth != 0.0 ? vec4(one, 0.0) : vec4(0.0);
  counts = depth != 0.0 ? lightCount() : vec4(0.0);
}
