// Evaluation of the material of a visible triangle at a pixel, into the G-buffer and the data outputs. Define
// packSurface() after the include.
#ifndef LATELIGHT_RESOLVE_GLSL
#define LATELIGHT_RESOLVE_GLSL
#include "shared/color.h"

// kTargets, bit i: target i is written; the bit after the last: light. kSrgb, bit i: target i is stored in sRGB.
layout(constant_id = kResolvedTargetsConstant) const uint kTargets = ~0u;
layout(constant_id = kSrgbConstant) const uint kSrgb = 0u;

#define IMAGE_vec4 image2DArray
#define IMAGE_uint uimage2DArray
#define IMAGE_uvec2 uimage2DArray
#define IMAGE_uvec4 uimage2DArray
#define TARGET(index, name, format, type, channels) \
  layout(set = 0, binding = index) writeonly uniform IMAGE_##type target_##name;
GBUFFER_TARGETS(TARGET)
#define COUNT(index, name, format, type, channels) +1
layout(set = 0, binding = 0 GBUFFER_TARGETS(COUNT), rgba16f) writeonly uniform image2DArray lightAccumulation;

vec4 stored(uint index, vec4 v) {
  return (kSrgb >> index & 1u) != 0u ? vec4(srgbFromLinear(clamp(v.rgb, 0.0, 1.0)), v.a) : v;
}
uvec4 stored(uint index, uint v) { return uvec4(v, 0u, 0u, 0u); }
uvec4 stored(uint index, uvec2 v) { return uvec4(v, 0u, 0u); }
uvec4 stored(uint index, uvec4 v) { return v; }

void store(ivec3 pixel, GbufferTexel texel, vec4 light) {
#define STORE(index, name, format, type, channels) \
  if ((kTargets >> index & 1u) != 0u) imageStore(target_##name, pixel, stored(index, texel.name));
  GBUFFER_TARGETS(STORE)
  if ((kTargets >> (0 GBUFFER_TARGETS(COUNT)) & 1u) != 0u) imageStore(lightAccumulation, pixel, light);
}

GbufferTexel emptyTexel() {
  GbufferTexel texel;
#define EMPTY(index, name, format, type, channels) texel.name = type(0);
  GBUFFER_TARGETS(EMPTY)
  return texel;
}

// Writes the data outputs of a pixel. `depth`: device depth.
void packSurface(View view, Surface s, float depth, ivec3 pixel);

// `texel`: where the targets store the pixel. `place`: the point in the image to evaluate. `depth`: device depth.
void resolveTriangle(FrameConstants frame, View view, ivec3 pixel, ivec3 texel, vec2 place, VisibleTriangle t,
                     float depth) {
  SurfacePoint p = visiblePoint(frame, view, t, place);
  Surface s = evaluateMaterial(frame, frameMaterial(frame, frameInstance(frame, t.draw.instance).material), p);
  if (kPacksOutputs) packSurface(view, s, depth, pixel);
  vec4 light = emittedLight(frame, s);
  s = storedSurface(s);
#ifdef GBUFFER_KEEPS_MOTION
  s.motion = seenMotion(frame, view, uint(pixel.z), t, place).xy;
#endif
  store(texel, packGbuffer(s, gbufferContext(view, place)), light);
}

#endif
