// Pixels whose paths start at the eye, because the G-buffer has neither coats nor translucent surfaces. Include after
// lit_pixel.glsl.
#ifndef LATELIGHT_PATH_EYE_GLSL
#define LATELIGHT_PATH_EYE_GLSL
#include "render/glsl/eye_ray.glsl"
#include "render/lighting/reference/paths_push.h"

layout(constant_id = kPathsFromLightsConstant) const uint kPathFlags = 0;  // kPaths* of paths_push.h

uint translucentRays() { return (kPathFlags & kPathsFindTranslucent) != 0u ? kRayAnySurface : 0u; }

// The first surface on a ray from the eye.
struct EyeRay {
  Ray ray;
  bool starts;  // coats or a translucent surface: paths start at the eye
  vec3 position;
};

EyeRay eyeRay(FrameConstants frame, View view, LitPixel p) {
  EyeRay eye = EyeRay(Ray(vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0.0), false, vec3(0.0));
  if ((kPathFlags & kPathsFromEye) == 0u) return eye;
  eye.ray = rayThrough(frame, view, vec2(p.place.xy) + 0.5);
  eye.starts = p.shadedSeparately || (p.s.flags & kSurfaceLayered) != 0u;
  RayHit hit = traceRay(frame, eye.ray, translucentRays());
  if (!isHit(hit)) return eye;
  uint64_t material = frame.materials + uint64_t(frameInstance(frame, hit.instance).material) * kMaterialBytes;
  uint flags = sceneWordsAt(material, 4u).y;
  eye.starts = eye.starts || (flags & (kMaterialLayered | kMaterialBlended | kMaterialTransmissive)) != 0u;
  eye.position = eye.ray.origin + eye.ray.direction * hit.distance;
  return eye;
}

#endif
