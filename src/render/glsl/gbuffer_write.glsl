// What becomes of a Surface in the G-buffer of the layout this shader is compiled for, whatever found it.
#ifndef LATELIGHT_GBUFFER_WRITE_GLSL
#define LATELIGHT_GBUFFER_WRITE_GLSL
#include "render/glsl/setup.glsl"
#include "gbuffer_layout.h"
#include "render/glsl/gbuffer_context.glsl"

const float kLitElsewhere = -1.0;

// The light accumulation target: emitted radiance, and ambient occlusion. For surfaces with layers, which render/layered
// lights, that they are.
vec4 emittedLight(FrameConstants frame, Surface s) {
  bool layered = (s.flags & kSurfaceLayered) != 0u;
  return vec4(min(emittedRadiance(s) * frame.exposure, vec3(65504.0)), layered ? kLitElsewhere : s.ao);
}

// As the layout keeps it: without flags, a surface that lights must leave alone is one that reflects nothing.
Surface keptSurface(Surface s) {
#ifndef GBUFFER_KEEPS_FLAGS
  s = litSurface(s);
#endif
  return s;
}

#endif
