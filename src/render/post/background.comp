#version 460
#extension GL_GOOGLE_include_directive : require
// Background: composites the picture over the environment, in pixels that surfaces cover partly or not at all. Reads
// and writes lightTarget, premultiplied by alpha.
#include "render/glsl/common.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/post/background_push.h"
#include "shared/environment.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0, rgba16f) uniform image2DArray lightTarget;
layout(set = 0, binding = 1) uniform sampler2D environmentPicture;  // equirectangular

layout(push_constant, scalar) uniform Push { BackgroundPush push; };

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  if (kWorlds != 0u && (frame.environmentMap & kEnvironmentLayerMask) != push.environment) return;
  View view = frameView(frame, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  vec4 drawn = imageLoad(lightTarget, pixel);
  if (drawn.a == 1.0) return;
  vec3 ray = pixelRay(frame, view, vec2(pixel.xy) + 0.5);
  if (ray == vec3(0.0)) return;
  vec3 direction = normalize(view.viewToWorld * vec4(ray, 0.0));
  vec2 uv = equirectangular(rotateToEnvironment(direction, frame.environmentCos, frame.environmentSin));
  vec3 radiance = textureLod(environmentPicture, uv, 0.0).rgb * frame.environmentIntensity;
  vec3 behind = min(radiance * frame.exposure, vec3(65504.0)) * (1.0 - drawn.a);
  imageStore(lightTarget, pixel, vec4(min(drawn.rgb + behind, vec3(65504.0)), 1.0));
}
