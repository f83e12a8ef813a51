// Light volumes: shades a surface that a light's volume covers with that light. Include it after gbuffer_read.glsl,
// with GBUFFER_SAMPLED_ONLY defined.
#include "render/glsl/environment.glsl"
#include "render/glsl/one_light.glsl"
#include "render/lighting/volumes/volume_push.h"

layout(push_constant, scalar) uniform Push { VolumePush push; };

// A uniform buffer, because on lavapipe loads by address cost more than shading with the light.
layout(set = 0, binding = AFTER_LIT_MAPS, scalar) uniform ViewUniform { View view; };

layout(location = 0) out vec4 radiance;
layout(location = 1) out vec4 counts;

// `samples` is the mask of samples that show the surface; 0 if there is no surface.
void lightSurface(ivec3 pixel, uint samples) {
#ifdef MULTISAMPLED
  float depth = depthOfSamples(gbufferDepth, pixel, samples);
  Surface s = readSurface(view, pixel, max(samples, 1u), depth, 1.0);  // occlusion affects only the environment
#else
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  Surface s = readSurface(view, pixel, depth, 1.0);
#endif
  s = litSurface(s);
  vec3 toEye = directionToEye(view, s.position);
  prepareForLights(s, toEye);
  FrameConstants frame = FrameRef(push.frame).v;
  vec3 one = shadeOneLight(frame, push.light, push.shadow, s, surfaceBrdf(s, toEye, kShading));
  lightsTested = 1.0;
  // Volumes that reach the far plane also cover background.
  radiance = depth != 0.0 ? vec4(one, 0.0) : vec4(0.0);
  counts = depth != 0.0 ? lightCount() : vec4(0.0);
}
