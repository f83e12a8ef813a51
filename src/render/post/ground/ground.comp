#version 460
#extension GL_GOOGLE_include_directive : require
// A plane that only receives shadows (a shadow catcher): its color is black, and its alpha is the share of the light
// that something blocks, 1 - E / E0. E0 is the irradiance of the plane from all lights and the environment, and E that
// with shadows (Debevec 1998, Rendering Synthetic Objects into Real Scenes, composites by the same ratio). Both are
// estimated with the same samples, so alpha is exactly 0 where nothing blocks any of them.
//
// Inputs: gbufferDepth, the scene's BVHs, the environment's image and cells. Input and output: lightTarget,
// premultiplied. With several passes, groundSum accumulates (E, E0). If paths draw blended surfaces into lightTarget
// before this pass, push.coversBlended is 0, and these surfaces lie over the plane.
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/glsl/sobol.glsl"
#include "render/glsl/light_choice.glsl"
#include "render/post/ground/ground_push.h"
#include "shared/surface.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray gbufferDepth;
layout(set = 0, binding = 1, rgba16f) uniform image2DArray lightTarget;
layout(set = 0, binding = 2) uniform sampler2D environmentPicture;  // equirectangular
layout(set = 0, binding = 3, rgba32f) uniform image2DArray groundSum;
#define SKY_PICTURE environmentPicture
#include "render/glsl/sky_samples.glsl"

layout(push_constant, scalar) uniform Push { GroundPush push; };

// Returns false if the pixel's ray does not meet the plane from above, or meets a surface first. Surfaces that lie in
// the plane hide it.
bool meetsGround(FrameConstants frame, View view, ivec3 pixel, float depth, out vec3 position, out float away) {
  vec2 ndc = pixelToNdc(vec2(pixel.xy) + 0.5, view.size);
  vec3 from = vec3(0.0), along = vec3(0.0);
  if (kLens != 0u) {
    along = pixelRay(frame, view, vec2(pixel.xy) + 0.5);
  } else {
    from = viewPositionAtDepth(view.projection, ndc, 0.0);
    along = viewPositionAtDepth(view.projection, ndc, 1.0) - from;
  }
  vec3 start = view.viewToWorld * vec4(from, 1.0), way = view.viewToWorld * vec4(along, 0.0);
  float above = start.z - push.height;
  away = above / max(-way.z, 1e-30);
  position = vec3(start.xy + away * way.xy, push.height);
  bool isFirst = depth == 0.0 || away < viewDepth(view.projection, depth) * 0.999;
  return above > 0.0 && way.z < 0.0 && away < 1e7 && isFirst;
}

Surface whitePlane(vec3 position) {
  Surface s = emptySurface();
  s.position = position;
  s.normal = s.geonormal = vec3(0.0, 0.0, 1.0);
  s.baseColor = vec3(1.0);
  s.roughness = 1.0;
  s.f0 = vec3(0.0);
  s.f90 = 0.0;
  return s;
}

// Returns directions in turn in proportion to the environment's brightness and to the cosine. Both are weighted by
// their mean density (Veach and Guibas 1995, Optimally Combining Sampling Techniques for Monte Carlo Rendering).
vec3 directionToSky(FrameConstants frame, RayScene scene, uint index, uint seed) {
  bool byCosine = (index & 1u) != 0u;
  uvec2 bits = sobolBits(index >> 1u, byCosine ? 1u : 2u, seed);
  if (!byCosine) return sampleSky(frame, scene, bits).direction;
  vec2 disk = diskSample(rayUnit(bits));
  return vec3(disk, sqrt(max(1.0 - dot(disk, disk), 0.0)));
}

// Returns (E, E0) / pi of one sample, as luminance.
vec2 sampleGround(FrameConstants frame, RayScene scene, Surface s, SurfaceBrdf brdf, float fromEye, uint index, uint seed) {
  vec2 light = vec2(0.0);
  LightChoice choice = chooseLight(frame, s, brdf, kShadingGgx, sobolSample(index, 0u, seed));
  float sent = luminance(choice.light);
  if (sent > 0.0)
    light += vec2(isShadowed(frame, s, fromEye, choice) ? 0.0 : sent, sent);
  vec3 toSky = vec3(0.0, 0.0, -1.0);
  if (hasCells(scene, frame)) toSky = directionToSky(frame, scene, index, seed);
  if (toSky.z > 0.0) {
    float density = 0.5 * (toSky.z * kInvPi + skyDensity(frame, scene, toSky));
    sent = luminance(skyRadiance(frame, toSky)) * toSky.z * kInvPi / density;
    light += vec2(isBlocked(frame, surfaceRay(s, fromEye, toSky, 3.0e38)) ? 0.0 : sent, sent);
  }
  return light;
}

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  if (!isOwnSky(frame, push.environment)) return;
  View view = frameView(frame, pixel.z);
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  vec3 position;
  float away;
  float depth = texelFetch(gbufferDepth, pixel, 0).r;
  if (!meetsGround(frame, view, pixel, depth, position, away)) return;
  RayScene scene = loadRayScene(frame.rayScene);
  Surface s = whitePlane(position);
  SurfaceBrdf brdf = surfaceBrdf(s, s.normal, kShadingGgx);
  float fromEye = distance(position, view.eye);
  uint seed = rayHash(floatBitsToUint(position)).x;
  vec2 sum = push.first > 0u ? imageLoad(groundSum, pixel).rg : vec2(0.0);
  uint i = push.first;
  do {  // tested at the end, because lavapipe would execute the body once more
    sum += sampleGround(frame, scene, s, brdf, fromEye, i, seed);
  } while (++i < push.end);
  if (push.end < push.samples) {
    imageStore(groundSum, pixel, vec4(sum, 0.0, 0.0));
    return;
  }
  float alpha = sum.y > 0.0 ? clamp(1.0 - sum.x / sum.y, 0.0, 1.0) : 0.0;
  vec4 drawn = imageLoad(lightTarget, pixel);
  // Without a surface in the G-buffer, the picture consists of blended surfaces only.
  bool isBlended = push.coversBlended == 0u && depth == 0.0;
  vec3 color = isBlended ? drawn.rgb : drawn.rgb * (1.0 - alpha);
  imageStore(lightTarget, pixel, vec4(color, alpha + drawn.a * (1.0 - alpha)));
}
