// Ambient occlusion in shaders that draw the scene lit: binding 0 of set 0, before the environment's maps. After
// varyings.glsl.
#include "render/glsl/setup.glsl"
#define ENVIRONMENT_BINDING 1
layout(set = 0, binding = 0) uniform sampler2DArray ambientOcclusion;

float occlusionHere() {
  if (kAmbientOcclusion == 0u) return 1.0;
  return texelFetch(ambientOcclusion, ivec3(ivec2(gl_FragCoord.xy), int(push.view)), 0).r;
}
