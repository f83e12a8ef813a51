// Transmission background: the light behind a transmissive surface, sampled from the picture of the opaque scene in
// screen space, and from the environment if nothing is drawn there (KHR_materials_transmission). Include after
// environment.glsl. behind_push.h describes the arrangement of the levels.
#include "render/layered/behind_push.h"

layout(set = 0, binding = AFTER_LIT_MAPS) uniform sampler2DArray behind;  // render/layered/behind.h

// Samples a level at `place`, which is from 0 to 1 across and down the picture.
vec4 backgroundMip(vec2 place, uint level, uint view, uvec2 size) {
  vec2 corner = vec2(backgroundMipCorner(size, level)), texels = vec2(backgroundMipSize(size, level));
  vec2 at = corner + clamp(place * texels, vec2(0.5), texels - 0.5);  // only texels of this level
  return textureLod(behind, vec3(at / vec2(textureSize(behind, 0).xy), float(view)), 0.0);
}

// Samples with the blur that KHR_materials_transmission proposes. At roughness 1 it averages the entire picture.
vec4 blurredBackground(vec2 place, float roughness, uint view, uvec2 size) {
  float level = min(roughness * log2(float(size.x)), float(backgroundMips(size) - 1u));
  uint finer = uint(level);
  vec4 fine = backgroundMip(place, finer, view, size);
  vec4 coarse = backgroundMip(place, min(finer + 1u, backgroundMips(size) - 1u), view, size);
  return mix(fine, coarse, level - float(finer));
}

// The position in the picture, from 0 to 1, at which the eye sees a point in world space. With a lens, refraction is
// ignored and the result is `own`, the pixel's own position.
vec2 projectedPosition(View view, vec3 position, vec2 own) {
  if (kLens != 0u) return own / view.size;
  vec4 clip = projectToClip(view.projection, view.worldToView * vec4(position, 1.0));
  vec2 ndc = clip.xy / max(clip.w, 1.0e-6);
  return vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
}

// Returns the radiance behind the surface along the transmitted ray, times exposure.
vec3 backgroundRadiance(FrameConstants frame, uint viewIndex, TransmittedRay ray, vec2 own) {
  View view = frameView(frame, viewIndex);
  vec4 seen = blurredBackground(projectedPosition(view, ray.exit, own), ray.roughness, viewIndex, uvec2(view.size));
  if (seen.a >= 1.0 || !hasEnvironment(frame)) return seen.rgb;
  vec3 wide = environmentDiffuseAt(frame, ray.direction);
  vec3 around = environmentLobe(frame, ray.direction, ray.direction, ray.roughness, wide);  // a mirror seen head-on
  return seen.rgb + around * (frame.environmentIntensity * frame.exposure * (1.0 - seen.a));
}
