// What lies behind a transmissive surface: the opaque scene as the eye sees it, and where nothing is drawn there the
// environment. After environment.glsl; behind_push.h says how its levels lie.
#include "render/layered/behind_push.h"

layout(set = 0, binding = AFTER_LIT_MAPS) uniform sampler2DArray behind;  // render/layered/behind.h

// Of the picture, from 0 to 1 across and down, at a level.
vec4 behindLevel(vec2 place, uint level, uint view, uvec2 size) {
  vec2 corner = vec2(behindLevelCorner(size, level)), texels = vec2(behindLevelSize(size, level));
  vec2 at = corner + clamp(place * texels, vec2(0.5), texels - 0.5);  // between this level's texels alone
  return textureLod(behind, vec3(at / vec2(textureSize(behind, 0).xy), float(view)), 0.0);
}

// As blurred as KHR_materials_transmission proposes: at roughness 1 all of the picture is one.
vec4 behindBlurred(vec2 place, float roughness, uint view, uvec2 size) {
  float level = min(roughness * log2(float(size.x)), float(behindLevels(size) - 1u));
  uint finer = uint(level);
  vec4 fine = behindLevel(place, finer, view, size);
  vec4 coarse = behindLevel(place, min(finer + 1u, behindLevels(size) - 1u), view, size);
  return mix(fine, coarse, level - float(finer));
}

// Where the eye sees a point of the world. Through a lens it looks straight on, at `own`.
vec2 placeSeen(View view, vec3 position, vec2 own) {
  if (kLens != 0u) return own / view.size;
  vec4 clip = projectToClip(view.projection, view.worldToView * vec4(position, 1.0));
  vec2 ndc = clip.xy / max(clip.w, 1.0e-6);
  return vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
}

// Radiance times exposure.
vec3 radianceBehind(FrameConstants frame, uint viewIndex, TransmittedRay ray, vec2 own) {
  View view = frameView(frame, viewIndex);
  vec4 seen = behindBlurred(placeSeen(view, ray.exit, own), ray.roughness, viewIndex, uvec2(view.size));
  if (seen.a >= 1.0 || !hasEnvironment(frame)) return seen.rgb;
  vec3 wide = environmentDiffuseAt(frame, ray.direction);
  vec3 around = environmentLobe(frame, ray.direction, ray.direction, ray.roughness, wide);  // as of a mirror seen head-on
  return seen.rgb + around * (frame.environmentIntensity * frame.exposure * (1.0 - seen.a));
}
