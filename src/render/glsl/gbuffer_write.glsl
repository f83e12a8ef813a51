// What becomes of a Surface in the G-buffer of the layout this shader is compiled for, whatever found it.
#ifndef LATELIGHT_GBUFFER_WRITE_GLSL
#define LATELIGHT_GBUFFER_WRITE_GLSL
#include "render/glsl/setup.glsl"
#include "gbuffer_layout.h"
#include "render/glsl/gbuffer_context.glsl"

// The light accumulation target: emitted radiance, and ambient occlusion.
vec4 emittedLight(FrameConstants frame, Surface s) {
  vec3 emitted = (s.flags & kSurfaceUnlit) != 0u ? s.baseColor : s.emissive;
  return vec4(min(emitted * frame.exposure, vec3(65504.0)), s.ao);
}

// As the layout keeps it: without flags, an unlit surface is one that reflects nothing.
Surface keptSurface(Surface s) {
#ifndef GBUFFER_KEEPS_FLAGS
  if ((s.flags & kSurfaceUnlit) != 0u) s = withoutReflection(s);
#endif
  return s;
}

#endif
